/* The scene blob. What opens is walked as a worker would: every vertex of every placed triangle,
 * every texel's address, every name; the address sanitizer watches. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/scene.h"

static void walk_mesh(const struct scene *s, const struct scene_mesh *m, double *sum)
{
    for (uint32_t t = 0; t < m->triangle_count; t++)
        for (uint32_t corner = 0; corner < 3; corner++) {
            const uint32_t v = s->triangles[3 * ((uint64_t)m->first_triangle + t) + corner];
            /* Embree reads 16 bytes a vertex. */
            float wide[4];
            memcpy(wide, s->positions + 3 * ((uint64_t)m->first_vertex + v), sizeof wide);
            *sum += (double)wide[0];
            if (m->flags & MESH_HAS_NORMALS)
                *sum += (double)s->normals[3 * ((uint64_t)m->first_normal + v) + 2];
            if (m->flags & MESH_HAS_TANGENTS)
                *sum += (double)s->tangents[4 * ((uint64_t)m->first_tangent + v) + 3];
            for (int set = 0; set < 2; set++)
                if (m->first_uv[set] != SCENE_NONE)
                    *sum += (double)s->uvs[2 * ((uint64_t)m->first_uv[set] + v) + 1];
        }
    *sum += (double)s->materials[m->material].roughness;
}

static void walk_images(const struct scene *s, double *sum)
{
    for (uint64_t i = 0; i < s->count[SCENE_TEXTURES]; i++) {
        const struct scene_image *image = &s->images[s->textures[i].image];
        *sum += s->pixels[image->first_byte];
        *sum += s->pixels[image->first_byte + 4ull * image->width_px * image->height_px - 1];
    }
}

/* Every texture that a material names, down to its image. */
static void walk_material(const struct scene *s, const struct scene_material *m, double *sum)
{
    const struct scene_texture_ref *refs[] = {
        &m->base_color_texture,     &m->metallic_roughness_texture, &m->normal_texture,
        &m->emission_texture,       &m->transmission_texture,       &m->specular_texture,
        &m->specular_color_texture, &m->anisotropy_texture};
    for (size_t i = 0; i < sizeof refs / sizeof refs[0]; i++)
        if (refs[i]->texture != SCENE_NONE)
            *sum += s->images[s->textures[refs[i]->texture].image].width_px;
    *sum += (double)strlen(scene_name(s, m->name));
    /* what shading divides by or takes logarithms of */
    for (int i = 0; i < 3; i++)
        if (!(m->attenuation[i] > 0.0f)) abort();
    if (m->ior > 0.0f && m->ior < 1.0f) abort();
    if (m->model >= MODEL_COUNT) abort();
}

static void walk(const struct scene *s)
{
    volatile double kept;
    double sum = 0.0;
    for (uint64_t i = 0; i < s->count[SCENE_INSTANCES]; i++)
        walk_mesh(s, &s->meshes[s->instances[i].mesh], &sum);
    walk_images(s, &sum);
    for (uint64_t i = 0; i < s->count[SCENE_MATERIALS]; i++)
        walk_material(s, &s->materials[i], &sum);
    for (uint64_t i = 0; i < s->count[SCENE_CAMERAS]; i++)
        sum += (double)strlen(scene_name(s, s->cameras[i].name));
    if (!(s->info->flags & SCENE_IS_BASE))
        sum += (double)s->cameras[s->info->default_camera].eye[0];
    for (uint64_t at = 0; at < s->count[SCENE_WARNINGS];) at += strlen(s->warnings + at) + 1;
    kept = sum;
    (void)kept;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct scene scene;
    struct fault fault = {0};
    void *blob;
    if (posix_memalign(&blob, SCENE_ALIGN_BYTES, size_bytes + (size_bytes == 0))) abort();
    memcpy(blob, data, size_bytes);
    const int error = scene_open(blob, size_bytes, &scene, &fault);
    if (error && (fault.code != error || fault.detail[0] == '\0')) abort();
    if (!error) walk(&scene);
    free(blob);
    return 0;
}
