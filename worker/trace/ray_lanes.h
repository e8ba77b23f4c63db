#pragma once
/* lane_kernels' sanitise, aim and add_stratum: rays on their way to Embree and back. Included by
 * lane_kernels_body.h only. */
#include <math.h>
#include <string.h>

#include "worker/trace/light.h"
#include "worker/trace/shadow_sums.h"

/* Embree's own bound is 1e18; farther origins abort the process. */
#define ORIGIN_MAX 1e18f

/* Comparisons are false for NaN. */
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

static uint32_t kernel_aim(const struct light_sample *restrict s,
                           const struct lanes_mask *restrict lit, struct RTCRay16 *restrict r,
                           struct lanes_mask *restrict traced)
{
    int32_t count = 0;
    for (int i = 0; i < LANES; i++) {
        r->dir_x[i] = s->way.x[i];
        r->dir_y[i] = s->way.y[i];
        r->dir_z[i] = s->way.z[i];
        r->tfar[i] = s->tfar;
        traced->on[i] = s->skip[i] == LIGHT_TRACED ? lit->on[i] : 0;
        count -= traced->on[i];
    }
    return (uint32_t)count;
}

/* Blocked rays have a tfar before the light's end: -infinity from occlusion queries, the blocker's
 * t from closest-hit ones. */
static void kernel_add_stratum(const struct light_sample *restrict s,
                               const struct lanes_mask *restrict traced, const float *restrict tfar,
                               uint32_t bit, struct shadow_sums *restrict sums)
{
    for (int i = 0; i < LANES; i++) {
        int32_t blocked = tfar[i] < s->tfar ? traced->on[i] : 0;
        int32_t unfit = s->irradiance[i] < INFINITY ? 0 : traced->on[i];
        int32_t arrives = traced->on[i] & ~blocked & ~unfit;
        float t = tfar[i] > 0.0f ? tfar[i] : 0.0f;
        float near = blocked ? t : 1.0f, far = blocked ? t : 0.0f;
        sums->row[i] += arrives ? s->irradiance[i] : 0.0f;
        sums->seen[i] |= (~blocked & 1) << bit;
        sums->blocked.on[i] |= blocked;
        sums->least[i] = near < sums->least[i] ? near : sums->least[i];
        sums->most[i] = far > sums->most[i] ? far : sums->most[i];
        sums->rejected.on[i] += unfit;
    }
}
