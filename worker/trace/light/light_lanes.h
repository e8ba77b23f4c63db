#pragma once
/* light_kernels' sample_light. */
#include <math.h>

#include "worker/trace/hit/primary.h"
#include "worker/trace/light/gaussian_lanes.h"
#include "worker/trace/light/light.h"

/* Shadow rays end this little short of their light, so that what the light is set into (a bulb, a
 * ceiling) does not hide it by rounding. */
#define SHADOW_END 0.9999f

/* Returns LIGHT_NOT_FINITE where Embree could not take rays from the lane's origin. */
LANE_INLINE int32_t judge_origin(const struct surface *r, int i)
{
    int fit = (fabsf(r->origin.x[i]) < ORIGIN_MAX) & (fabsf(r->origin.y[i]) < ORIGIN_MAX) &
              (fabsf(r->origin.z[i]) < ORIGIN_MAX);
    return fit ? LIGHT_TRACED : LIGHT_NOT_FINITE;
}

/* Finds whether lane i goes to Embree, its ray along (dx, dy, dz), from the receiver's origin up to
 * a point unless it goes on without end, and why not. Comparisons are false for NaN. Choices follow
 * each other and masks are numbers, since the compiler makes branches, or scalar code, of
 * conditions that depend on each other. */
LANE_INLINE void finish_lane(const struct surface *r, const struct lanes_mask *lanes, int i,
                             int32_t origin, int32_t skip, float dx, float dy, float dz,
                             float irradiance, struct light_packet *out)
{
    struct RTCRay16 *ray = &out->rays.ray;
    int fit = (fabsf(dx) < INFINITY) & (fabsf(dy) < INFINITY) & (fabsf(dz) < INFINITY) &
              (irradiance < INFINITY);
    int32_t unfit = fit ? origin : LIGHT_NOT_FINITE;
    skip = skip == LIGHT_TRACED ? unfit : skip;
    out->skip[i] = skip;
    out->traced.on[i] = lanes->on[i] & -(skip == LIGHT_TRACED);
    out->irradiance[i] = irradiance;
    const struct vector start = surface_start(r, i, dx, dy, dz);
    const bool ends = out->end < INFINITY;
    ray->org_x[i] = start.x;
    ray->org_y[i] = start.y;
    ray->org_z[i] = start.z;
    ray->dir_x[i] = dx - (ends ? start.x - r->origin.x[i] : 0.0f);
    ray->dir_y[i] = dy - (ends ? start.y - r->origin.y[i] : 0.0f);
    ray->dir_z[i] = dz - (ends ? start.z - r->origin.z[i] : 0.0f);
    ray->tfar[i] = out->end;
}

/* Samples the point (x, y, z) of a rectangle, whose brightness there is `profile`. `weighed`:
 * densities are computed, too. */
LANE_INLINE void sample_point_of_rectangle(const struct light *light, const struct surface *r,
                                           const struct lanes_mask *lanes, int i, int32_t origin,
                                           float x, float y, float z, float profile, bool weighed,
                                           struct light_packet *out)
{
    const float *n = light->plan->direction;
    float wx = x - r->position.x[i], wy = y - r->position.y[i], wz = z - r->position.z[i];
    float squared = wx * wx + wy * wy + wz * wz;
    float shading = wx * r->normal.x[i] + wy * r->normal.y[i] + wz * r->normal.z[i];
    float facet = wx * r->facet.x[i] + wy * r->facet.y[i] + wz * r->facet.z[i];
    float front = -(wx * n[0] + wy * n[1] + wz * n[2]);
    int32_t skip = facet > 0.0f ? LIGHT_TRACED : LIGHT_BELOW_FACET;
    skip = front > 0.0f ? skip : LIGHT_FACING_AWAY;
    skip = shading > 0.0f ? skip : LIGHT_BELOW_HORIZON;
    float inverse = 1.0f / squared; /* positive where traced, since front is */
    float irradiance = (shading * inverse) * (front * inverse) * light->area * profile;
    /* In front of the emitter's own geometry, and never behind the receiver. */
    float half_way = 0.5f * front;
    float clear = light->clearance < half_way ? light->clearance : half_way;
    if (weighed) out->density[i] = squared * sqrtf(squared) / (front * light->area);
    finish_lane(r, lanes, i, origin, skip, x + clear * n[0] - r->origin.x[i],
                y + clear * n[1] - r->origin.y[i], z + clear * n[2] - r->origin.z[i], irradiance,
                out);
}

/* Samples a rectangle. `profiled`: it has a Gaussian profile. */
LANE_INLINE void sample_rectangle(const struct light *light, const float *restrict u,
                                  const float *restrict v, const struct surface *restrict r,
                                  const struct lanes_mask *restrict lanes, bool weighed,
                                  bool profiled, struct light_packet *restrict out)
{
    const struct plan_light *p = light->plan;
    const float *c = p->position, *hu = p->half_u, *hv = p->half_v;
    for (int i = 0; i < LANES; i++) {
        float a = 2.0f * u[i] - 1.0f, b = 2.0f * v[i] - 1.0f;
        float x = c[0] + a * hu[0] + b * hv[0], y = c[1] + a * hu[1] + b * hv[1];
        float z = c[2] + a * hu[2] + b * hv[2];
        float profile = profiled ? gaussian(2.0f * (a * a + b * b)) : 1.0f;
        sample_point_of_rectangle(light, r, lanes, i, judge_origin(r, i), x, y, z, profile, weighed,
                                  out);
    }
}

/* Samples a point or a spot. A point's cone lets everything through. */
static void sample_point(const struct light *light, const struct surface *restrict r,
                         const struct lanes_mask *restrict lanes, struct light_packet *restrict out)
{
    const struct plan_light *p = light->plan;
    const float *c = p->position, *along = p->direction;
    int has_cone = p->type == LIGHT_SPOT;
    for (int i = 0; i < LANES; i++) {
        float wx = c[0] - r->position.x[i], wy = c[1] - r->position.y[i];
        float wz = c[2] - r->position.z[i];
        float squared = wx * wx + wy * wy + wz * wz;
        float distance = sqrtf(squared), inverse = 1.0f / distance; /* used only above horizons */
        float shading = wx * r->normal.x[i] + wy * r->normal.y[i] + wz * r->normal.z[i];
        float facet = wx * r->facet.x[i] + wy * r->facet.y[i] + wz * r->facet.z[i];
        float ratio = distance * light->inverse_range, ratio2 = ratio * ratio;
        float window = 1.0f - ratio2 * ratio2;
        float cosine = -(wx * along[0] + wy * along[1] + wz * along[2]) * inverse;
        float cone = (cosine - p->cos_outer) * light->cone_scale;
        cone = has_cone && cone < 1.0f ? cone : 1.0f;
        int32_t skip = cone > 0.0f ? LIGHT_TRACED : LIGHT_OUT_OF_CONE;
        skip = window > 0.0f ? skip : LIGHT_OUT_OF_RANGE;
        skip = shading > 0.0f ? skip : LIGHT_BELOW_HORIZON;
        skip = facet > 0.0f ? skip : LIGHT_BELOW_HORIZON;
        out->density[i] = 0.0f;
        finish_lane(r, lanes, i, judge_origin(r, i), skip, c[0] - r->origin.x[i],
                    c[1] - r->origin.y[i], c[2] - r->origin.z[i],
                    cone * cone * window * (shading * inverse) / squared, out);
    }
}

static void sample_directional(const struct light *light, const struct surface *restrict r,
                               const struct lanes_mask *restrict lanes,
                               struct light_packet *restrict out)
{
    const float *d = light->plan->direction;
    for (int i = 0; i < LANES; i++) {
        float shading = -(d[0] * r->normal.x[i] + d[1] * r->normal.y[i] + d[2] * r->normal.z[i]);
        float facet = -(d[0] * r->facet.x[i] + d[1] * r->facet.y[i] + d[2] * r->facet.z[i]);
        int32_t skip = shading > 0.0f ? LIGHT_TRACED : LIGHT_BELOW_HORIZON;
        skip = facet > 0.0f ? skip : LIGHT_BELOW_HORIZON;
        out->density[i] = 0.0f;
        finish_lane(r, lanes, i, judge_origin(r, i), skip, -d[0], -d[1], -d[2], shading, out);
    }
}

static void kernel_sample_light(const struct light *restrict light, const float *restrict u,
                                const float *restrict v, const struct surface *restrict receiver,
                                const struct lanes_mask *restrict lanes,
                                struct light_packet *restrict out)
{
    out->end = SHADOW_END;
    switch ((enum light_type)light->plan->type) {
    case LIGHT_POINT:
    case LIGHT_SPOT:
        sample_point(light, receiver, lanes, out);
        break;
    case LIGHT_DIRECTIONAL:
        out->end = INFINITY;
        sample_directional(light, receiver, lanes, out);
        break;
    case LIGHT_RECTANGLE:
        if (light->plan->profile == PROFILE_GAUSSIAN)
            sample_rectangle(light, u, v, receiver, lanes, true, true, out);
        else
            sample_rectangle(light, u, v, receiver, lanes, true, false, out);
        break;
    }
}
