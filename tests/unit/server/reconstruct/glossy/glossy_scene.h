#pragma once
/* A floor under a perspective camera whose glossy lobes look at a wall of stripes, as samples of it
 * would come. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "server/reconstruct/glossy/glossy.h"
#include "tests/unit/unit.h"

static inline void floor_plan(struct plan *plan, int32_t side, uint32_t filter, uint32_t l)
{
    *plan = (struct plan){
        .width_px = side,
        .height_px = side,
        .tile_px = 64,
        .pattern = {.seed = 5, .frame = 1},
        .camera = {.type = CAMERA_PERSPECTIVE,
                   .eye = {0, 1, 0},
                   .right = {1, 0, 0},
                   .up = {0, 0.8f, -0.6f},
                   .forward = {0, -0.6f, -0.8f},
                   .half_width = 0.4f,
                   .half_height = 0.4f},
        .paths = {.spp = l * l, .without_diffuse_indirect = 1, .without_glossy_indirect = 1},
        .glossy_filter = filter,
        .mu = 1,
        .planes = PLANES_GLOSSY_LIGHT | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) |
                  PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(PATH_RADIANCE),
        .bounces = 1,
        .indirect_strata_per_axis = l,
        .radiance_scale = 1,
        .length_unit = 1,
    };
}

static inline float floor_random(uint32_t *state)
{
    return path_unit(path_mix(++*state));
}

/* Where the ray through pixel (x, y) meets the floor y = 0. */
static inline float floor_point(const struct plan *plan, int32_t x, int32_t y, float at[3],
                                float d[3])
{
    float o[3];
    plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
    const float t = -o[1] / d[1];
    for (int k = 0; k < 3; k++) at[k] = o[k] + t * d[k];
    return t;
}

#define WALL_Z (-4.0f)

/* Radiance of the wall z = WALL_Z, far enough behind the floor to be seen in all of it: soft
 * stripes. */
static inline float wall_radiance(float x, float y)
{
    return 1.0f + 0.5f * sinf(2.0f * x) * cosf(3.0f * y);
}

/* Rays in a regular order, so many that their mean is the truth. */
#define TRUTH_AXIS 64u
#define TRUTH      (TRUTH_AXIS * TRUTH_AXIS)

/* What a lobe of roughness alpha sees from the floor: n rays around the mirrored direction. */
static inline void floor_lobe(const float at[3], const float d[3], float alpha, uint32_t n,
                              uint32_t *state, float *light, float *nearness)
{
    *light = *nearness = 0.0f;
    for (uint32_t k = 0; k < n; k++) {
        const bool true_one = n == TRUTH;
        const float u =
            true_one ? ((float)(k % TRUTH_AXIS) + 0.5f) / TRUTH_AXIS : floor_random(state);
        const float v =
            true_one ? ((float)(k / TRUTH_AXIS) + 0.5f) / TRUTH_AXIS : floor_random(state);
        const float r = 1.33f * alpha * sqrtf(-2.0f * logf(u + 1e-7f));
        const float turn = 6.2831853f * v;
        const float w[3] = {d[0] + r * cosf(turn), fabsf(-d[1] + 0.7f * r * sinf(turn)),
                            d[2] < -0.1f ? d[2] : -0.1f};
        const float t = (WALL_Z - at[2]) / w[2];
        *light += wall_radiance(at[0] + t * w[0], at[1] + t * w[1]) / (float)n;
        *nearness += 1.0f / (t * sqrtf(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])) / (float)n;
    }
}

/* The patch of `rect`: alpha by a chequer of 8 px where two are given. */
static inline struct patch *floor_patch(const struct plan *plan, struct rect rect, float alpha,
                                        float other, uint32_t n)
{
    struct patch *p;
    assert_int_equal(patch_create(plan, rect, &p), 0);
    for (int32_t y = rect.y0; y < rect.y1; y++)
        for (int32_t x = rect.x0; x < rect.x1; x++) {
            const size_t i = patch_pixel(p, x, y);
            float at[3], d[3], light, near;
            uint32_t state = path_mix((uint32_t)(y * plan->width_px + x));
            const float own = (x / 8 + y / 8) % 2 ? other : alpha;
            p->depth[i] = floor_point(plan, x, y, at, d);
            p->id[i] = 1;
            for (int k = 0; k < 3; k++) p->normal[k][i] = k == 1 ? 1.0f : 0.0f;
            floor_lobe(at, d, own, n, &state, &light, &near);
            for (int k = 0; k < 3; k++) p->glossy[k][i] = light;
            for (int k = 0; k < 3; k++) p->reflectance[k][i] = 0.5f;
            p->glossy_weight[i] = 1.0f;
            p->glossy_alpha[i] = own;
            p->glossy_nearness[i] = near;
        }
    return p;
}

/* Halves of the rays of a patch, and the means of both, in place of what it has: rays of any two
 * halves are independent here. */
static inline void floor_halves(const struct plan *plan, struct patch *p, float alpha, uint32_t n)
{
    for (int32_t y = p->rect.y0; y < p->rect.y1; y++)
        for (int32_t x = p->rect.x0; x < p->rect.x1; x++) {
            const size_t i = patch_pixel(p, x, y);
            float at[3], d[3], half, other, near, far;
            uint32_t state =
                path_mix((uint32_t)(y * plan->width_px + x) + 7919u * (plan->pattern.frame + 1));
            floor_point(plan, x, y, at, d);
            floor_lobe(at, d, alpha, n / 2, &state, &half, &near);
            floor_lobe(at, d, alpha, n / 2, &state, &other, &far);
            for (int k = 0; k < 3; k++) {
                p->glossy[k][i] = 0.5f * (half + other);
                p->glossy_half[k][i] = half;
            }
            p->glossy_half_weight[i] = 1.0f;
            p->glossy_nearness[i] = 0.5f * (near + far);
        }
}

struct floor_picture {
    float *channel[3];
    struct glossy_statistics statistics;
};

static inline struct floor_picture floor_filter(const struct plan *plan, const struct patch *patch,
                                                struct rect inner)
{
    struct floor_picture out = {.statistics = {0}};
    const size_t area = (size_t)rect_area(patch->rect);
    for (int c = 0; c < 3; c++) out.channel[c] = calloc(area, sizeof(float));
    assert_int_equal(glossy_filter(plan, patch, inner, out.channel, &out.statistics), 0);
    return out;
}

static inline void floor_picture_fini(struct floor_picture *p)
{
    for (int c = 0; c < 3; c++) free(p->channel[c]);
}

static inline double floor_rms(const float *a, const float *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += ((double)a[i] - b[i]) * ((double)a[i] - b[i]);
    return sqrt(sum / (double)count);
}
