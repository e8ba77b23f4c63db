#include "tests/unit/worker/scene_fixture.h"

#include <assert.h>
#include <math.h>
#include <string.h>

const struct scene *fixture_scene(struct scene_fixture *f)
{
    struct scene *s = &f->scene;
    memset(s, 0, sizeof *s);
    s->info = &f->info;
    s->positions = f->positions;
    s->normals = f->normals;
    s->tangents = f->tangents;
    s->uvs = f->uvs;
    s->colors = f->colors;
    s->triangles = f->triangles;
    s->meshes = f->meshes;
    s->instances = f->instances;
    s->materials = f->materials;
    s->textures = f->textures;
    s->images = f->images;
    s->pixels = f->pixels;
    s->names = f->names ? f->names : "";
    s->warnings = "";
    s->count[SCENE_MESHES] = f->mesh_count;
    s->count[SCENE_INSTANCES] = f->instance_count;
    s->count[SCENE_MATERIALS] = f->material_count;
    s->count[SCENE_TEXTURES] = f->texture_count;
    s->count[SCENE_IMAGES] = f->texture_count;
    return s;
}

uint32_t fixture_material(struct scene_fixture *f, float r, float g, float b)
{
    struct scene_material *m = &f->materials[f->material_count];
    *m = (struct scene_material){.base_color = {r, g, b, 1.0f},
                                 .normal_scale = 1.0f,
                                 .roughness = 1.0f,
                                 .ior = 1.5f,
                                 .specular_color = {1, 1, 1},
                                 .attenuation = {1, 1, 1}};
    struct scene_texture_ref none = {.texture = SCENE_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    m->base_color_texture = m->normal_texture = m->emission_texture = none;
    m->metallic_roughness_texture = m->transmission_texture = m->specular_texture = none;
    m->specular_color_texture = m->anisotropy_texture = none;
    m->clearcoat_texture = m->clearcoat_roughness_texture = m->clearcoat_normal_texture = none;
    m->sheen_color_texture = m->sheen_roughness_texture = none;
    m->iridescence_texture = m->iridescence_thickness_texture = none;
    m->diffuse_transmission_texture = m->diffuse_transmission_color_texture = none;
    m->clearcoat_normal_scale = 1.0f;
    m->iridescence_ior = 1.3f;
    return f->material_count++;
}

uint32_t fixture_glossy(struct scene_fixture *f, const float color[3], float roughness,
                        float metallic)
{
    const uint32_t m = fixture_material(f, color[0], color[1], color[2]);
    f->materials[m].specular = 1.0f;
    f->materials[m].roughness = roughness;
    f->materials[m].metallic = metallic;
    return m;
}

uint32_t fixture_texture(struct scene_fixture *f, uint32_t w, uint32_t h, const uint8_t *rgba,
                         uint32_t image_flags)
{
    assert(f->texel_count + w * h <= FIXTURE_TEXELS);
    f->images[f->texture_count] = (struct scene_image){.width_px = w,
                                                       .height_px = h,
                                                       .flags = image_flags,
                                                       .first_byte = 4 * (uint64_t)f->texel_count};
    memcpy(f->pixels + (size_t)4 * f->texel_count, rgba, (size_t)4 * w * h);
    f->textures[f->texture_count] = (struct scene_texture){.image = f->texture_count};
    f->texel_count += w * h;
    return f->texture_count++;
}

uint32_t fixture_mesh(struct scene_fixture *f, uint32_t material, uint32_t flags)
{
    f->meshes[f->mesh_count] = (struct scene_mesh){.first_vertex = f->vertex_count,
                                                   .first_normal = f->vertex_count,
                                                   .first_tangent = f->vertex_count,
                                                   .first_color = f->vertex_count,
                                                   .first_uv = {f->vertex_count, SCENE_NONE},
                                                   .first_triangle = f->triangle_count,
                                                   .material = material,
                                                   .flags = flags};
    return f->mesh_count++;
}

uint32_t fixture_vertex(struct scene_fixture *f, float x, float y, float z)
{
    assert(f->vertex_count < FIXTURE_VERTICES);
    struct scene_mesh *m = &f->meshes[f->mesh_count - 1];
    float *p = f->positions + (size_t)3 * f->vertex_count++;
    p[0] = x, p[1] = y, p[2] = z;
    return m->vertex_count++;
}

void fixture_triangle(struct scene_fixture *f, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *t = f->triangles + (size_t)3 * f->triangle_count++;
    t[0] = a, t[1] = b, t[2] = c;
    f->meshes[f->mesh_count - 1].triangle_count++;
}

void fixture_quad(struct scene_fixture *f, const float c[3], const float u[3], const float v[3])
{
    uint32_t corner[4];
    for (int i = 0; i < 4; i++) {
        float a = i == 1 || i == 2 ? 1.0f : -1.0f, b = i >= 2 ? 1.0f : -1.0f;
        float *uv = f->uvs + (size_t)2 * f->vertex_count;
        uv[0] = 0.5f + 0.5f * a, uv[1] = 0.5f + 0.5f * b;
        corner[i] = fixture_vertex(f, c[0] + a * u[0] + b * v[0], c[1] + a * u[1] + b * v[1],
                                   c[2] + a * u[2] + b * v[2]);
    }
    fixture_triangle(f, corner[0], corner[1], corner[2]);
    fixture_triangle(f, corner[0], corner[2], corner[3]);
}

uint32_t fixture_place(struct scene_fixture *f, uint32_t mesh)
{
    f->instances[f->instance_count] = (struct scene_instance){
        .mesh = mesh, .flags = INSTANCE_IDENTITY, .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    return f->instance_count++;
}

uint32_t fixture_place_at(struct scene_fixture *f, uint32_t mesh, const float m[12])
{
    f->instances[f->instance_count] = (struct scene_instance){.mesh = mesh};
    memcpy(f->instances[f->instance_count].to_world, m, 12 * sizeof m[0]);
    return f->instance_count++;
}

uint32_t fixture_panel(struct scene_fixture *f, uint32_t material, const float c[3],
                       const float u[3], const float v[3])
{
    uint32_t mesh = fixture_mesh(f, material, 0);
    fixture_quad(f, c, u, v);
    return fixture_place(f, mesh);
}

struct plan fixture_plan(int32_t w, int32_t h, const float eye[3], float half)
{
    struct plan p = {.width_px = w, .height_px = h, .tile_px = 32};
    p.pattern.seed = 7;
    p.camera = (struct plan_camera){.right = {1, 0, 0}, .up = {0, 1, 0}, .forward = {0, 0, -1}};
    memcpy(p.camera.eye, eye, 3 * sizeof eye[0]);
    p.camera.half_width = half;
    p.camera.half_height = half * (float)h / (float)w;
    p.planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ALBEDO) | PLANE_BIT(ID);
    p.light_planes =
        1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES;
    p.radiance_scale = 1.0f;
    p.length_unit = 1.0f;
    p.mu = 1.0f;
    return p;
}

void fixture_look(struct plan *p, const float forward[3], const float up[3])
{
    memcpy(p->camera.forward, forward, 3 * sizeof up[0]);
    memcpy(p->camera.up, up, 3 * sizeof up[0]);
    p->camera.right[0] = forward[1] * up[2] - forward[2] * up[1];
    p->camera.right[1] = forward[2] * up[0] - forward[0] * up[2];
    p->camera.right[2] = forward[0] * up[1] - forward[1] * up[0];
}

struct plan_light *fixture_light(struct plan *p, uint32_t type, uint32_t l)
{
    struct plan_light *light = &p->lights[p->light_count++];
    *light = (struct plan_light){.type = type,
                                 .direction = {0, -1, 0},
                                 .color = {1, 1, 1},
                                 .cos_inner = 1.0f,
                                 .power = 1.0f,
                                 .strata_per_axis = l};
    return light;
}

struct plan_light *fixture_ceiling_light(struct plan *p, float x, float y, float z, float half,
                                         uint32_t l)
{
    struct plan_light *light = fixture_light(p, LIGHT_RECTANGLE, l);
    light->position[0] = x, light->position[1] = y, light->position[2] = z;
    light->half_u[0] = half;
    light->half_v[2] = half;
    return light;
}

void fixture_bounces(struct plan *p, uint32_t l)
{
    p->bounces = 1;
    p->indirect_strata_per_axis = l;
    p->planes |= PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) |
                 PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(INDIRECT_STRATA);
}
