#pragma once
/* The inner loop of path_kernels that bounds how much each group of emitters lights a surface. */
#include <math.h>
#include <string.h>

#include "worker/scene/emitter_groups.h"
#include "worker/trace/path/path.h"

/* Larger ones would not add up. */
#define EMITTER_LIGHT_MOST 1e30f

/* Returns the cosine of the difference of two angles, or 1 where it is below 0. */
LANE_INLINE float cosine_less(float cosine, float sine, float by_cosine, float by_sine)
{
    const float less = cosine * by_cosine + sine * by_sine;
    return cosine >= by_cosine ? 1.0f : less;
}

LANE_INLINE float sine_of(float cosine)
{
    const float squared = 1.0f - cosine * cosine;
    return sqrtf(squared > 0.0f ? squared : 0.0f);
}

LANE_INLINE float positive(float x)
{
    return x > 0.0f ? x : 0.0f;
}

/* Bounds the irradiance that each group may send to surfaces at `origin` that face along `normal`,
 * whatever is in between, and sums the bounds up. */
static void kernel_group_light(const struct emitter_groups *restrict e,
                               const struct lanes3 *restrict origin,
                               const struct lanes3 *restrict normal,
                               struct group_light *restrict out)
{
    _Alignas(LANES_ALIGN) float total[LANES] = {0};
    for (uint32_t g = 0; g < e->count; g++) {
        const float radius = e->radius[g], power = e->power[g];
        const float at_x = e->x[g], at_y = e->y[g], at_z = e->z[g];
        const float axis_x = e->axis_x[g], axis_y = e->axis_y[g], axis_z = e->axis_z[g];
        const float cone = e->cosine[g], cone_sine = e->sine[g], least = radius * radius;
        float *restrict light = out->group[g];
        for (int i = 0; i < LANES; i++) {
            const float x = at_x - origin->x[i], y = at_y - origin->y[i], z = at_z - origin->z[i];
            const float squared = x * x + y * y + z * z;
            const float near = squared > least ? squared : least;
            const float over = 1.0f / sqrtf(near > 0.0f ? near : 1.0f);
            const float fills = radius * over; /* sine of half the angle; 1 inside */
            const float beside = sine_of(fills);
            const float facing = (x * normal->x[i] + y * normal->y[i] + z * normal->z[i]) * over;
            const float away = -(x * axis_x + y * axis_y + z * axis_z) * over;
            const float out_of_cone = cosine_less(away, sine_of(away), cone, cone_sine);
            const float receives = cosine_less(facing, sine_of(facing), beside, fills);
            const float sends = cosine_less(out_of_cone, sine_of(out_of_cone), beside, fills);
            const float both = positive(receives) * positive(sends) * over;
            const float value = power * (squared > least ? both : over) * over;
            light[i] = value < EMITTER_LIGHT_MOST ? value : EMITTER_LIGHT_MOST;
            total[i] += light[i];
        }
    }
    memcpy(out->total, total, sizeof total);
}
