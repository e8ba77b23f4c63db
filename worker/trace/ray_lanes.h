#pragma once
/* lane_kernels' sanitise, add_stratum and add_slopes: rays before Embree and after. Included by
 * lane_kernels_body.h only, after light_lanes.h. */
#include <math.h>

#include "worker/trace/light.h"
#include "worker/trace/shadow_sums.h"

static uint32_t kernel_sanitise(const struct RTCRay16 *restrict r,
                                struct lanes_mask *restrict valid)
{
    int32_t rejected = 0;
    for (int i = 0; i < LANES; i++) {
        int32_t origin = (fabsf(r->org_x[i]) < ORIGIN_MAX) & (fabsf(r->org_y[i]) < ORIGIN_MAX) &
                         (fabsf(r->org_z[i]) < ORIGIN_MAX);
        int32_t direction = (fabsf(r->dir_x[i]) < INFINITY) & (fabsf(r->dir_y[i]) < INFINITY) &
                            (fabsf(r->dir_z[i]) < INFINITY);
        int32_t usable = -(origin & direction & (r->tnear[i] >= 0.0f) & (r->tfar[i] > r->tnear[i]));
        rejected -= valid->on[i] & ~usable;
        valid->on[i] &= usable;
    }
    return (uint32_t)rejected;
}

/* Blocked rays have a tfar before their end: -infinity from occlusion queries, the blocker's t from
 * closest-hit ones. */
static void kernel_add_stratum(const struct light_packet *restrict p, uint32_t bit,
                               struct shadow_sums *restrict sums)
{
    const float *restrict tfar = p->rays.ray.tfar;
    for (int i = 0; i < LANES; i++) {
        int32_t blocked = tfar[i] < p->end ? p->traced.on[i] : 0;
        int32_t arrives = p->traced.on[i] & ~blocked;
        blocked |= -(p->skip[i] == LIGHT_BELOW_FACET);
        sums->row[i] += arrives ? p->irradiance[i] : 0.0f;
        sums->seen[i] |= (blocked + 1) << bit;
    }
}

static void kernel_add_slopes(const struct light_packet *restrict p,
                              struct shadow_sums *restrict sums)
{
    const float *restrict tfar = p->rays.ray.tfar;
    for (int i = 0; i < LANES; i++) {
        int32_t blocked = tfar[i] < p->end ? p->traced.on[i] : 0;
        float near = blocked ? tfar[i] : 1.0f, far = blocked ? tfar[i] : 0.0f;
        sums->blocked.on[i] |= blocked;
        sums->least[i] = near < sums->least[i] ? near : sums->least[i];
        sums->most[i] = far > sums->most[i] ? far : sums->most[i];
    }
}
