#include "worker/scene/movers.h"

#include <stdlib.h>
#include <string.h>

int movers_find(const struct scene *blob, const struct scene_step ***out)
{
    *out = NULL;
    if (blob->count[SCENE_MOVERS] == 0) return 0;
    const struct scene_step **steps = calloc((size_t)blob->count[SCENE_INSTANCES], sizeof *steps);
    if (!steps) return ERR_MEMORY;
    for (uint64_t i = 0; i < blob->count[SCENE_MOVERS]; i++)
        steps[blob->movers[i].instance] = &blob->steps[i * SHUTTER_STEPS];
    *out = steps;
    return 0;
}

void mover_to_world(const struct render_scene *s, uint32_t instance, float time, float out[12])
{
    const struct scene_step *steps = mover_steps(s, instance);
    if (!steps) {
        memcpy(out, s->blob->instances[instance].to_world, 12 * sizeof *out);
        return;
    }
    const struct shutter_place at = shutter_place_of(time);
    const float *a = steps[at.before].to_world, *b = steps[at.before + 1].to_world;
    for (int i = 0; i < 12; i++) out[i] = shutter_mix(at, a[i], b[i]);
}

/* Mixes the same triangle of two arrays of vectors. */
static void mix_triangle(struct shutter_place at, const uint32_t *triangle, const float *before,
                         const float *after, float out[9])
{
    for (size_t k = 0; k < 3; k++)
        for (size_t c = 0; c < 3; c++) {
            const size_t i = 3 * (size_t)triangle[k] + c;
            out[3 * k + c] = shutter_mix(at, before[i], after[i]);
        }
}

void mover_corners(const struct render_scene *s, uint32_t instance, uint32_t triangle, float time,
                   float corners[9], float normals[9])
{
    const struct shutter_place at = shutter_place_of(time);
    const struct scene_step *a = mover_steps(s, instance) + at.before, *b = a + 1;
    const struct mesh_view *mesh = &s->meshes[s->blob->instances[instance].mesh];
    const uint32_t *of = mesh->triangles + (size_t)3 * triangle;
    const float *places = s->blob->positions, *all = s->blob->normals;
    mix_triangle(at, of, places + (size_t)3 * a->first_vertex, places + (size_t)3 * b->first_vertex,
                 corners);
    if (mesh->normals)
        mix_triangle(at, of, all + (size_t)3 * a->first_normal, all + (size_t)3 * b->first_normal,
                     normals);
}
