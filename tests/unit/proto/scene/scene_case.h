#pragma once
/* A small scene with a record of every kind, as arrays for tests to change and then to lay out as a
 * blob. */
#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "proto/scene/scene.h"

struct scene_case {
    struct scene_info info;
    float positions[7][3];
    float normals[4][3];
    float tangents[4][4];
    float uvs[4][2];
    float colors[4][4];
    uint32_t triangles[3][3];
    struct scene_mesh meshes[3]; /* mesh_count of them */
    uint64_t mesh_count;
    struct scene_instance instances[5]; /* instance_count of them */
    uint64_t instance_count;
    struct scene_material materials[2];
    struct scene_texture textures[1];
    struct scene_image images[1];
    uint8_t pixels[16];
    struct scene_light lights[2];
    struct scene_camera cameras[2];
    char names[16];
    char warnings[24];
    struct digest base;
    uint64_t base_count; /* 0: none */
    struct scene_mover movers[2];
    struct scene_step steps[2 * SHUTTER_STEPS];
    struct scene_camera poses[2 * SHUTTER_STEPS];
    uint64_t mover_count, step_count, pose_count; /* 0: none */
    float sky[SCENE_SKY_TEXELS][3];
    uint32_t sky_count;
};

static inline void scene_case_geometry(struct scene_case *c)
{
    static const float positions[7][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1},
                                          {0, 0, 0},   {1, 0, 0},  {0, 1, 0}};
    static const float uvs[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const uint32_t triangles[3][3] = {{0, 1, 2}, {0, 2, 3}, {0, 1, 2}};
    memcpy(c->positions, positions, sizeof positions);
    memcpy(c->uvs, uvs, sizeof uvs);
    memcpy(c->triangles, triangles, sizeof triangles);
    for (int i = 0; i < 4; i++) {
        c->normals[i][1] = 1;
        c->tangents[i][0] = 1;
        c->tangents[i][3] = i & 1 ? -1 : 1;
        c->colors[i][i] = 1;
    }
    c->meshes[0] =
        (struct scene_mesh){.vertex_count = 4,
                            .triangle_count = 2,
                            .first_uv = {0, SCENE_NONE},
                            .flags = MESH_HAS_NORMALS | MESH_HAS_TANGENTS | MESH_HAS_COLORS,
                            .name = 1};
    c->meshes[1] = (struct scene_mesh){.first_vertex = 4,
                                       .vertex_count = 3,
                                       .first_triangle = 2,
                                       .triangle_count = 1,
                                       .first_uv = {SCENE_NONE, SCENE_NONE},
                                       .material = 1,
                                       .flags = MESH_IS_LIGHT,
                                       .name = 6};
    for (uint32_t i = 0; i < 3; i++)
        c->instances[i] = (struct scene_instance){.mesh = i > 0,
                                                  .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    c->instances[0].flags = INSTANCE_IDENTITY;
    c->instances[2].to_world[0] = -2; /* mirrored: still invertible */
    c->instances[2].to_world[3] = 5;
}

static inline void scene_case_surfaces(struct scene_case *c)
{
    const struct scene_texture_ref none = {SCENE_NONE, 0, {1, 0, 0, 0, 1, 0}};
    for (int i = 0; i < 2; i++)
        c->materials[i] = (struct scene_material){.base_color = {0.5f, 0.25f, 1, 1},
                                                  .roughness = 1,
                                                  .normal_scale = 1,
                                                  .alpha_cutoff = 0.5f,
                                                  .specular = 1,
                                                  .ior = 1.5f,
                                                  .base_color_texture = none,
                                                  .metallic_roughness_texture = none,
                                                  .normal_texture = none,
                                                  .emission_texture = none,
                                                  .specular_color = {1, 1, 1},
                                                  .attenuation = {1, 1, 1},
                                                  .iridescence_ior = 1.3f,
                                                  .transmission_texture = none,
                                                  .specular_texture = none,
                                                  .specular_color_texture = none,
                                                  .anisotropy_texture = none,
                                                  .clearcoat_texture = none,
                                                  .clearcoat_roughness_texture = none,
                                                  .clearcoat_normal_texture = none,
                                                  .sheen_color_texture = none,
                                                  .sheen_roughness_texture = none,
                                                  .iridescence_texture = none,
                                                  .iridescence_thickness_texture = none,
                                                  .diffuse_transmission_texture = none,
                                                  .diffuse_transmission_color_texture = none};
    c->materials[0].base_color_texture.texture = 0;
    c->materials[1].emission[0] = 20;
    c->textures[0].wrap_u = WRAP_CLAMP;
    c->images[0] = (struct scene_image){.width_px = 2, .height_px = 2, .flags = IMAGE_IS_SRGB};
    for (int i = 0; i < 16; i++) c->pixels[i] = (uint8_t)(i * 16);
}

static inline void scene_case_lights(struct scene_case *c)
{
    c->lights[0] = (struct scene_light){.type = LIGHT_RECTANGLE,
                                        .position = {0, 4, 0},
                                        .direction = {0, -1, 0},
                                        .half_u = {1, 0, 0},
                                        .half_v = {0, 0, 1},
                                        .color = {20, 20, 20},
                                        .instance = 1};
    c->lights[1] = (struct scene_light){.type = LIGHT_SPOT,
                                        .direction = {0, 0, -1},
                                        .color = {1, 1, 1},
                                        .cos_inner = 1,
                                        .cos_outer = 0.5f,
                                        .instance = SCENE_NONE};
}

static inline void scene_case_cameras(struct scene_case *c)
{
    for (int i = 0; i < 2; i++)
        c->cameras[i] = (struct scene_camera){.eye = {0, 1, 5},
                                              .right = {1, 0, 0},
                                              .up = {0, 1, 0},
                                              .forward = {0, 0, -1},
                                              .yfov_rad = 0.7f};
    c->cameras[1].type = CAMERA_ORTHOGRAPHIC;
    c->cameras[1].half_width = c->cameras[1].half_height = 2;
    c->cameras[1].is_default = 1;
}

static inline void scene_case_init(struct scene_case *c)
{
    memset(c, 0, sizeof *c);
    c->info = (struct scene_info){.bounds_min = {-1, 0, -1},
                                  .bounds_max = {5, 1, 1},
                                  .placed_triangles = 4,
                                  .default_camera = 1};
    c->mesh_count = 2;
    c->instance_count = 3;
    scene_case_geometry(c);
    scene_case_surfaces(c);
    scene_case_lights(c);
    scene_case_cameras(c);
    memcpy(c->names, "\0quad\0light\0", 12);
    memcpy(c->warnings, "first\0second one\0", 17);
}

struct scene_case_section {
    const void *data;
    uint64_t count;
    uint32_t record_bytes;
};

#define SCENE_CASE_ARRAY(array)                                                                    \
    {                                                                                              \
        (array), sizeof(array) / sizeof(array)[0], sizeof(array)[0]                                \
    }
#define SCENE_CASE_BYTES 36864u

/* Lays the case out into SCENE_CASE_BYTES bytes at an address that is a multiple of 64; returns the
 * blob's size. */
static inline size_t scene_case_lay_out(const struct scene_case *c, uint8_t *blob)
{
    const struct scene_case_section sections[SCENE_SECTION_COUNT] = {
        {&c->info, 1, sizeof c->info},
        SCENE_CASE_ARRAY(c->positions),
        SCENE_CASE_ARRAY(c->normals),
        SCENE_CASE_ARRAY(c->tangents),
        SCENE_CASE_ARRAY(c->uvs),
        SCENE_CASE_ARRAY(c->triangles),
        {c->meshes, c->mesh_count, sizeof c->meshes[0]},
        {c->instances, c->instance_count, sizeof c->instances[0]},
        SCENE_CASE_ARRAY(c->materials),
        SCENE_CASE_ARRAY(c->textures),
        SCENE_CASE_ARRAY(c->images),
        SCENE_CASE_ARRAY(c->pixels),
        SCENE_CASE_ARRAY(c->lights),
        SCENE_CASE_ARRAY(c->cameras),
        SCENE_CASE_ARRAY(c->names),
        SCENE_CASE_ARRAY(c->warnings),
        SCENE_CASE_ARRAY(c->colors),
        {&c->base, c->base_count, sizeof c->base},
        {c->movers, c->mover_count, sizeof c->movers[0]},
        {c->steps, c->step_count, sizeof c->steps[0]},
        {c->poses, c->pose_count, sizeof c->poses[0]},
        {c->sky, c->sky_count, sizeof c->sky[0]}};
    struct scene_header *header = (void *)blob;
    struct scene_section_entry *table = (void *)(header + 1);
    size_t at = sizeof *header + SCENE_SECTION_COUNT * sizeof *table;
    memset(blob, 0, SCENE_CASE_BYTES);
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) {
        const size_t size_bytes = sections[s].count * sections[s].record_bytes;
        at = (at + SCENE_ALIGN_BYTES - 1) / SCENE_ALIGN_BYTES * SCENE_ALIGN_BYTES;
        table[s] = (struct scene_section_entry){
            .offset = at, .count = sections[s].count, .record_bytes = sections[s].record_bytes};
        memcpy(blob + at, sections[s].data, size_bytes);
        at += size_bytes;
    }
    at += 16;
    memcpy(header->magic, SCENE_MAGIC, sizeof header->magic);
    header->version = SCENE_VERSION;
    header->section_count = SCENE_SECTION_COUNT;
    header->total_bytes = at;
    return at;
}
