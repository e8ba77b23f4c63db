#pragma once
/* Small scenes made by hand: a struct scene over arrays of the test's own, without a blob. */
#include <stdint.h>

#include "proto/samples.h"
#include "proto/scene/scene.h"

enum { FIXTURE_VERTICES = 4096, FIXTURE_MESHES = 64, FIXTURE_TEXELS = 4096 };

struct scene_fixture {
    struct scene scene;
    struct scene_info info;
    float positions[3 * FIXTURE_VERTICES + 4];
    float normals[3 * FIXTURE_VERTICES + 4];
    float tangents[4 * FIXTURE_VERTICES + 4];
    float uvs[2 * FIXTURE_VERTICES + 4];
    float colors[4 * FIXTURE_VERTICES + 4];
    uint32_t triangles[3 * FIXTURE_VERTICES + 4];
    struct scene_mesh meshes[FIXTURE_MESHES];
    struct scene_instance instances[FIXTURE_MESHES];
    struct scene_material materials[FIXTURE_MESHES];
    struct scene_texture textures[FIXTURE_MESHES];
    struct scene_image images[FIXTURE_MESHES];
    uint8_t pixels[4 * FIXTURE_TEXELS];
    uint32_t vertex_count, triangle_count, mesh_count, instance_count, material_count;
    uint32_t texture_count, texel_count;
    const char *names; /* of SCENE_NAMES; NULL: none */
};

/* Points the view at the arrays as they are; call it when everything has been added. */
const struct scene *fixture_scene(struct scene_fixture *f);

/* A grey material; its index. Change its record for more. */
uint32_t fixture_material(struct scene_fixture *f, float r, float g, float b);

/* The same with a lobe of facets. */
uint32_t fixture_glossy(struct scene_fixture *f, const float color[3], float roughness,
                        float metallic);

/* An RGBA8 texture of w x h; its index. */
uint32_t fixture_texture(struct scene_fixture *f, uint32_t w, uint32_t h, const uint8_t *rgba,
                         uint32_t image_flags);

/* A mesh without triangles yet, not placed; its index. */
uint32_t fixture_mesh(struct scene_fixture *f, uint32_t material, uint32_t flags);

uint32_t fixture_vertex(struct scene_fixture *f, float x, float y, float z);
void fixture_triangle(struct scene_fixture *f, uint32_t a, uint32_t b, uint32_t c);

/* A parallelogram at centre c with half sides u and v into the newest mesh; its front shows where
 * u x v points, its UVs run from (0, 0) at -u -v to (1, 1) at u v. */
void fixture_quad(struct scene_fixture *f, const float c[3], const float u[3], const float v[3]);

/* Places a mesh where it stands; the instance's index. */
uint32_t fixture_place(struct scene_fixture *f, uint32_t mesh);

/* The same through a transform. */
uint32_t fixture_place_at(struct scene_fixture *f, uint32_t mesh, const float m[12]);

/* A quad of its own mesh, placed; the instance's index. */
uint32_t fixture_panel(struct scene_fixture *f, uint32_t material, const float c[3],
                       const float u[3], const float v[3]);

/* A plan of w x h pixels that looks from `eye` along -z, half the image `half` wide at distance 1,
 * with every plane of geometry and of lights. Neither lights nor bounces. */
struct plan fixture_plan(int32_t w, int32_t h, const float eye[3], float half);

/* Turns the plan's camera to look along `forward` with `up` upwards (orthonormal). */
void fixture_look(struct plan *p, const float forward[3], const float up[3]);

struct plan_light *fixture_light(struct plan *p, uint32_t type, uint32_t l);

/* A rectangle light facing down at (x, y, z), sides along x and z. */
struct plan_light *fixture_ceiling_light(struct plan *p, float x, float y, float z, float half,
                                         uint32_t l);

void fixture_bounces(struct plan *p, uint32_t l);
