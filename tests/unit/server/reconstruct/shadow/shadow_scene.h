#pragma once
/* A scene of formulas for the shadow filters: a floor, spheres, boxes and sticks under a rectangle
 * light, traced here, in the manner of the worker: one ray a pixel, l x l strata by the pattern,
 * the blockers' slopes as t / (1 - t). */
#include <stdbool.h>
#include <stdint.h>

#include "proto/samples.h"
#include "server/reconstruct/patch/patch.h"

enum shape { SHAPE_SPHERE, SHAPE_BOX, SHAPE_STICK };

struct solid {
    enum shape shape;
    float a[3], b[3], radius; /* sphere: a; box: corners; stick: ends */
    float centre[3], reach;   /* a ball around it */
};

#define SCENE_SOLIDS 48

struct shadow_scene {
    struct plan plan;
    struct solid solids[SCENE_SOLIDS];
    int solid_count;
    bool floor; /* z = 0 */
};

static inline float scene_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void scene_add(struct shadow_scene *s, enum shape shape, const float a[3], const float b[3],
               float radius);

#define SCENE_BOX(s, x, y, z, u, v, w)                                                             \
    scene_add(s, SHAPE_BOX, (float[]){x, y, z}, (float[]){u, v, w}, 0)

/* Depth (0: none) and normal of the pixel. */
float scene_primary(const struct shadow_scene *s, int32_t x, int32_t y, float p[3], float n[3]);

/* I G of plan.h, less the area: 0 where nothing is traced. */
float scene_weight(const struct plan_light *light, const float p[3], const float n[3], float u,
                   float v, float d[3]);

/* Irradiance by side x side strata with their own jitter, and the fraction seen; neither pattern
 * nor noise is shared with what the filters get. */
void scene_reference(const struct shadow_scene *s, uint32_t k, const float p[3], const float n[3],
                     uint32_t side, uint32_t seed, float *e, float *seen);

/* The samples of `rect`: depth, normals, all lights. Owned by the caller. */
struct patch *scene_patch(const struct shadow_scene *s, struct rect rect);

/* A light at `position` that shines along `direction`, its first axis near `along`. */
struct plan_light scene_light(const float position[3], const float direction[3],
                              const float along[3], float half_u, float half_v);

void scene_camera(struct plan *plan, const float eye[3], const float target[3], float half_height);

/* An empty floor below a tilted light of half-side `half`, l x l strata. */
void scene_init(struct shadow_scene *s, int32_t width, int32_t height, float half, uint32_t l);

/* Floating and standing occluders near and far, thin ones, curved receivers. */
void scene_furnish(struct shadow_scene *s);
