#pragma once
/* Bounds how much groups of emitters light surfaces, for the inner loops of path_kernels. */
#include <math.h>
#include <string.h>

#include "worker/scene/emitter_groups.h"
#include "worker/trace/path/path.h"

/* Larger ones would not add up. */
#define LIGHT_WEIGHT_MAX 1e30f

LANE_INLINE float positive(float x)
{
    return x > 0.0f ? x : 0.0f;
}

LANE_INLINE float at_max(float x, float most)
{
    return x < most ? x : most;
}

/* What emits: a sphere that holds it, (x, y, z) from the surface, and the cone of its normals. */
struct emitting {
    float x, y, z, radius;
    float axis_x, axis_y, axis_z, cosine, sine;
    float power;
};

/* Bounds the irradiance of a surface that faces along a normal, whatever is in between. Of cosines
 * over the sphere, which fills the half angle b, cos max(a - b, 0) is bounded by cos a + sin b:
 * both are above 0 for the same a, and this takes no root. */
LANE_INLINE float bound_irradiance(struct emitting e, float normal_x, float normal_y,
                                   float normal_z)
{
    const float squared = e.x * e.x + e.y * e.y + e.z * e.z, least = e.radius * e.radius;
    const float near = squared > least ? squared : least;
    const float over = 1.0f / sqrtf(near > 0.0f ? near : 1.0f);
    const float fills = e.radius * over; /* sine of half the angle; 1 inside */
    const float facing = (e.x * normal_x + e.y * normal_y + e.z * normal_z) * over;
    const float away = -(e.x * e.axis_x + e.y * e.axis_y + e.z * e.axis_z) * over;
    const float sine = sqrtf(positive(1.0f - away * away));
    const float beside = away * e.cosine + sine * e.sine;
    const float out_of_cone = away >= e.cosine ? 1.0f : beside;
    const float receives = at_max(facing + fills, 1.0f), sends = at_max(out_of_cone + fills, 1.0f);
    const float both = positive(receives) * positive(sends) * over;
    return at_max(e.power * (squared > least ? both : over) * over, LIGHT_WEIGHT_MAX);
}

/* Adds what each group may send to sixteen surfaces. */
LANE_INLINE void weigh_groups(const struct emitter_groups *restrict e,
                              const struct lanes3 *restrict origin,
                              const struct lanes3 *restrict normal, float weight[][LANES],
                              float *restrict total)
{
    for (uint32_t g = 0; g < e->count; g++) {
        const float at_x = e->x[g], at_y = e->y[g], at_z = e->z[g], radius = e->radius[g];
        const float axis_x = e->axis_x[g], axis_y = e->axis_y[g], axis_z = e->axis_z[g];
        const float cosine = e->cosine[g], sine = e->sine[g], power = e->power[g];
        float *restrict out = weight[g];
        for (int i = 0; i < LANES; i++) {
            const struct emitting from = {at_x - origin->x[i],
                                          at_y - origin->y[i],
                                          at_z - origin->z[i],
                                          radius,
                                          axis_x,
                                          axis_y,
                                          axis_z,
                                          cosine,
                                          sine,
                                          power};
            out[i] = bound_irradiance(from, normal->x[i], normal->y[i], normal->z[i]);
            total[i] += out[i];
        }
    }
}

/* Bounds what each group of a node may send to lane i's surface, and returns their sum. */
static float kernel_weigh_node(const struct emitter_groups *restrict e,
                               const struct lanes3 *restrict origin,
                               const struct lanes3 *restrict normal, int lane,
                               float *restrict weight)
{
    const float x = origin->x[lane], y = origin->y[lane], z = origin->z[lane];
    const float normal_x = normal->x[lane], normal_y = normal->y[lane], normal_z = normal->z[lane];
    _Alignas(LANES_ALIGN) float sums[EMITTER_GROUPS];
    for (uint32_t g = 0; g < EMITTER_GROUPS; g++) {
        const struct emitting from = {e->x[g] - x,  e->y[g] - y,  e->z[g] - z,  e->radius[g],
                                      e->axis_x[g], e->axis_y[g], e->axis_z[g], e->cosine[g],
                                      e->sine[g],   e->power[g]};
        weight[g] = bound_irradiance(from, normal_x, normal_y, normal_z);
    }
    /* Pairs first, in an order that vectors keep. */
    for (uint32_t g = 0; g < 8; g++) sums[g] = weight[g] + weight[g + 8];
    for (uint32_t g = 0; g < 4; g++) sums[g] += sums[g + 4];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}
