#pragma once
/* What a light gives to sixteen receivers, before visibility: proto/plan.h's irradiance scalar E of
 * one sample, the ray that decides whether it arrives, and why no ray is needed. light_kernels'
 * sample_light computes it. */
#include "proto/counter.h"
#include "worker/scene/light_table.h"
#include "worker/trace/hit/hit.h"

enum light_skip {
    LIGHT_TRACED = 0,
    LIGHT_BELOW_HORIZON = 1, /* of the shading normal; lights without area: or of the facet */
    LIGHT_FACING_AWAY = 2,
    LIGHT_OUT_OF_RANGE = 3,
    LIGHT_OUT_OF_CONE = 4,
    LIGHT_NOT_FINITE = 5, /* E is not, or Embree could not take the ray */
    LIGHT_BELOW_FACET = 6 /* above the shading normal's horizon, below the facet's: the surface
                             itself is in the way */
};

struct light_packet {
    struct RTCRayHit16 rays; /* to the light at t = 1, or along a direction */
    float end;               /* their tfar as sent */
    struct lanes_mask traced;
    _Alignas(LANES_ALIGN) float irradiance[LANES]; /* E, without the light's color */
    _Alignas(LANES_ALIGN) float density[LANES];    /* of the direction per solid angle; 0: a light
                                                      without extent */
    _Alignas(LANES_ALIGN) int32_t skip[LANES];     /* enum light_skip */
};

/* Copies lane i, so that lanes that chose different lights end up in one packet. `end` stays. */
static inline void light_take_lane(const struct light_packet *from, int i, struct light_packet *to)
{
    const struct RTCRay16 *source = &from->rays.ray;
    struct RTCRay16 *ray = &to->rays.ray;
    ray->org_x[i] = source->org_x[i];
    ray->org_y[i] = source->org_y[i];
    ray->org_z[i] = source->org_z[i];
    ray->dir_x[i] = source->dir_x[i];
    ray->dir_y[i] = source->dir_y[i];
    ray->dir_z[i] = source->dir_z[i];
    ray->tfar[i] = source->tfar[i];
    to->traced.on[i] = from->traced.on[i];
    to->irradiance[i] = from->irradiance[i];
    to->density[i] = from->density[i];
    to->skip[i] = from->skip[i];
}

/* Adds the skips of `lanes`, each `times` times, to their counters. */
void light_count_skips(const struct light_packet *p, const struct lanes_mask *lanes, uint32_t times,
                       struct counters *counters);
