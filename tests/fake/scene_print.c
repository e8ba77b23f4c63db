/* Prints a scene blob as JSON, for tests that look into what the importer made.
 *
 *   scene_print BLOB        counts, bounds, lights, cameras, materials, instances (at most 64)
 */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

#include "proto/scene/scene.h"

#define LISTED 64

static json_t *numbers(const float *v, int count)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(list, json_real((double)v[i]));
    return list;
}

static json_t *count_of(const struct scene *s, uint32_t section)
{
    return json_integer((json_int_t)s->count[section]);
}

static json_t *light(const struct scene *s, const struct scene_light *l)
{
    static const char *const types[] = {"point", "spot", "directional", "rectangle"};
    return json_pack("{s:s,s:s,s:o,s:o,s:o,s:o,s:o,s:f,s:f,s:f,s:b}", "type", types[l->type],
                     "name", scene_name(s, l->name), "position", numbers(l->position, 3),
                     "direction", numbers(l->direction, 3), "half_u", numbers(l->half_u, 3),
                     "half_v", numbers(l->half_v, 3), "color", numbers(l->color, 3), "cos_inner",
                     (double)l->cos_inner, "cos_outer", (double)l->cos_outer, "range",
                     (double)l->range, "has_instance", l->instance != SCENE_NONE);
}

static json_t *camera(const struct scene *s, const struct scene_camera *c)
{
    return json_pack("{s:s,s:s,s:o,s:o,s:o,s:o,s:f,s:f,s:f,s:f,s:b}", "type",
                     c->type == 0 ? "perspective" : "orthographic", "name", scene_name(s, c->name),
                     "eye", numbers(c->eye, 3), "right", numbers(c->right, 3), "up",
                     numbers(c->up, 3), "forward", numbers(c->forward, 3), "yfov_rad",
                     (double)c->yfov_rad, "aspect", (double)c->aspect, "half_width",
                     (double)c->half_width, "half_height", (double)c->half_height, "is_default",
                     c->is_default != 0);
}

static json_t *texture(const struct scene_texture_ref *t)
{
    if (t->texture == SCENE_NONE) return json_null();
    return json_pack("{s:i,s:i,s:o}", "texture", (int)t->texture, "uv_set", (int)t->uv_set,
                     "transform", numbers(t->transform, 6));
}

static json_t *textures_of(const struct scene_material *m)
{
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "base_color_texture",
                     texture(&m->base_color_texture), "metallic_roughness_texture",
                     texture(&m->metallic_roughness_texture), "normal_texture",
                     texture(&m->normal_texture), "emission_texture", texture(&m->emission_texture),
                     "transmission_texture", texture(&m->transmission_texture), "specular_texture",
                     texture(&m->specular_texture), "specular_color_texture",
                     texture(&m->specular_color_texture), "anisotropy_texture",
                     texture(&m->anisotropy_texture), "clearcoat_normal_texture",
                     texture(&m->clearcoat_normal_texture));
}

/* What the path tracer's models add. */
static json_t *scattering(const struct scene_material *m)
{
    static const char *const models[MODEL_COUNT] = {
#define MODEL(number, NAME, name) #name,
#include "proto/scene/model.def"
    };
    return json_pack("{s:s,s:f,s:o,s:f,s:f,s:f,s:f,s:o,s:f,s:o,s:f,s:f,s:f,s:f,s:o,s:o}", "model",
                     models[m->model], "specular", (double)m->specular, "specular_color",
                     numbers(m->specular_color, 3), "ior", (double)m->ior, "transmission",
                     (double)m->transmission, "anisotropy", (double)m->anisotropy, "anisotropy_rad",
                     (double)m->anisotropy_rad, "attenuation", numbers(m->attenuation, 3),
                     "attenuation_distance", (double)m->attenuation_distance, "model_specular",
                     numbers(m->model_specular, 3), "exponent_u", (double)m->exponent_u,
                     "exponent_v", (double)m->exponent_v, "alpha_u", (double)m->alpha_u, "alpha_v",
                     (double)m->alpha_v, "eta", numbers(m->eta, 3), "k", numbers(m->k, 3));
}

static json_t *material(const struct scene *s, const struct scene_material *m)
{
    json_t *json = json_pack(
        "{s:s,s:o,s:o,s:f,s:f,s:f,s:f,s:i,s:b,s:b}", "name", scene_name(s, m->name), "base_color",
        numbers(m->base_color, 4), "emission", numbers(m->emission, 3), "metallic",
        (double)m->metallic, "roughness", (double)m->roughness, "thickness", (double)m->thickness,
        "alpha_cutoff", (double)m->alpha_cutoff, "alpha_mode", (int)m->alpha_mode, "double_sided",
        (m->flags & MATERIAL_DOUBLE_SIDED) != 0, "unlit", (m->flags & MATERIAL_UNLIT) != 0);
    json_t *parts[2] = {scattering(m), textures_of(m)};
    for (int i = 0; i < 2; i++) {
        json_object_update(json, parts[i]);
        json_decref(parts[i]);
    }
    return json;
}

static json_t *instance(const struct scene *s, const struct scene_instance *i)
{
    const struct scene_mesh *mesh = &s->meshes[i->mesh];
    return json_pack("{s:s,s:i,s:i,s:b,s:b,s:b,s:b,s:i,s:o}", "name", scene_name(s, i->name),
                     "mesh", (int)i->mesh, "triangles", (int)mesh->triangle_count, "identity",
                     (i->flags & INSTANCE_IDENTITY) != 0, "is_light",
                     (mesh->flags & MESH_IS_LIGHT) != 0, "has_normals",
                     (mesh->flags & MESH_HAS_NORMALS) != 0, "has_tangents",
                     (mesh->flags & MESH_HAS_TANGENTS) != 0, "material", (int)mesh->material,
                     "to_world", numbers(i->to_world, 12));
}

static json_t *image(const struct scene *s, const struct scene_image *i)
{
    return json_pack("{s:s,s:i,s:i,s:b}", "name", scene_name(s, i->name), "width", (int)i->width_px,
                     "height", (int)i->height_px, "srgb", (i->flags & IMAGE_IS_SRGB) != 0);
}

static json_t *texture_record(const struct scene_texture *t)
{
    return json_pack("{s:i,s:i,s:i,s:i}", "image", (int)t->image, "wrap_u", (int)t->wrap_u,
                     "wrap_v", (int)t->wrap_v, "filter", (int)t->filter);
}

#define LIST(list, s, section, make)                                                               \
    json_t *list = json_array();                                                                   \
    for (uint64_t i = 0; i < (s)->count[section] && i < LISTED; i++)                               \
    json_array_append_new(list, make)

static json_t *describe(const struct scene *s)
{
    LIST(lights, s, SCENE_LIGHTS, light(s, &s->lights[i]));
    LIST(cameras, s, SCENE_CAMERAS, camera(s, &s->cameras[i]));
    LIST(materials, s, SCENE_MATERIALS, material(s, &s->materials[i]));
    LIST(instances, s, SCENE_INSTANCES, instance(s, &s->instances[i]));
    LIST(images, s, SCENE_IMAGES, image(s, &s->images[i]));
    LIST(textures, s, SCENE_TEXTURES, texture_record(&s->textures[i]));
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:I,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "vertices",
                     count_of(s, SCENE_POSITIONS), "triangles", count_of(s, SCENE_TRIANGLES),
                     "meshes", count_of(s, SCENE_MESHES), "instance_count",
                     count_of(s, SCENE_INSTANCES), "light_count", count_of(s, SCENE_LIGHTS),
                     "placed_triangles", (json_int_t)s->info->placed_triangles, "bounds_min",
                     numbers(s->info->bounds_min, 3), "bounds_max", numbers(s->info->bounds_max, 3),
                     "lights", lights, "cameras", cameras, "materials", materials, "instances",
                     instances, "images", images, "textures", textures);
}

int main(int argc, char **argv)
{
    struct scene scene;
    struct fault fault = {0};
    if (argc != 2) {
        fprintf(stderr, "scene_print BLOB\n");
        return 2;
    }
    if (scene_map(argv[1], &scene, &fault) != 0) {
        fprintf(stderr, "%s: %s\n", fault.pointer, fault.detail);
        return 1;
    }
    json_t *json = describe(&scene);
    int rc = json_dumpf(json, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(7)) == 0 ? 0 : 1;
    putchar('\n');
    json_decref(json);
    scene_unmap(&scene);
    return rc;
}
