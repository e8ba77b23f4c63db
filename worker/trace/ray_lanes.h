#pragma once
/* lane_kernels' sanitise. Included by lane_kernels_body.h only, after light_lanes.h. */
#include <math.h>

#include "worker/trace/light.h"

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
