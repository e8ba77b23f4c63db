#pragma once
/* lane_kernels' sample_light. Included by lane_kernels_body.h only. */
#include <math.h>

#include "worker/trace/light.h"

/* Shadow rays end this little short of their light, so that what the light is set into (a bulb, a
 * ceiling) does not hide it by rounding. */
#define SHADOW_END 0.9999f

/* Embree's own bound is 1e18; farther origins abort the process. */
#define ORIGIN_MAX 1e18f

/* exp(-x) for x in [0, 4], relative error below 2e-6: a series on [0, 1/4], squared four times. Our
 * own, so that bits do not hang on the C library. */
static inline float gaussian(float x)
{
    float y = x * (1.0f / 16);
    float s = 1.0f - y * (1.0f - y * (0.5f - y * (1.0f / 6 - y * (1.0f / 24 - y / 120))));
    s *= s;
    s *= s;
    s *= s;
    return s * s;
}

/* `weighed`: with densities. */
static inline void sample_rectangle(const struct light *light, const float *restrict u,
                                    const float *restrict v, const struct surface *restrict r,
                                    bool weighed, struct light_packet *restrict out)
{
    const struct plan_light *p = light->plan;
    const float *c = p->position, *hu = p->half_u, *hv = p->half_v, *n = p->direction;
    for (int i = 0; i < LANES; i++) {
        float a = 2.0f * u[i] - 1.0f, b = 2.0f * v[i] - 1.0f;
        float x = c[0] + a * hu[0] + b * hv[0], y = c[1] + a * hu[1] + b * hv[1];
        float z = c[2] + a * hu[2] + b * hv[2];
        float wx = x - r->position.x[i], wy = y - r->position.y[i], wz = z - r->position.z[i];
        float squared = wx * wx + wy * wy + wz * wz;
        float shading = wx * r->normal.x[i] + wy * r->normal.y[i] + wz * r->normal.z[i];
        float facet = wx * r->facet.x[i] + wy * r->facet.y[i] + wz * r->facet.z[i];
        float front = -(wx * n[0] + wy * n[1] + wz * n[2]);
        int below = !(shading > 0.0f), away = !(front > 0.0f);
        int lit = facet > 0.0f ? LIGHT_TRACED : LIGHT_BELOW_FACET;
        out->skip[i] = below ? LIGHT_BELOW_HORIZON : away ? LIGHT_FACING_AWAY : lit;
        float inverse = 1.0f / squared; /* positive where traced, since front is */
        out->irradiance[i] = (shading * inverse) * (front * inverse) * light->area;
        /* In front of the emitter's own geometry, and never behind the receiver. */
        float half_way = 0.5f * front;
        float clear = light->clearance < half_way ? light->clearance : half_way;
        if (weighed) out->density[i] = squared * sqrtf(squared) / (front * light->area);
        out->rays.ray.dir_x[i] = x + clear * n[0] - r->origin.x[i];
        out->rays.ray.dir_y[i] = y + clear * n[1] - r->origin.y[i];
        out->rays.ray.dir_z[i] = z + clear * n[2] - r->origin.z[i];
    }
}

/* The profile of a Gaussian rectangle. */
static void apply_profile(const float *restrict u, const float *restrict v,
                          struct light_packet *restrict out)
{
    for (int i = 0; i < LANES; i++) {
        float a = 2.0f * u[i] - 1.0f, b = 2.0f * v[i] - 1.0f;
        out->irradiance[i] *= gaussian(2.0f * (a * a + b * b));
    }
}

/* Point and spot; a point's cone lets everything through. */
static void sample_point(const struct light *light, const struct surface *restrict r,
                         struct light_packet *restrict out)
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
        int below = !((shading > 0.0f) & (facet > 0.0f));
        int far = !(window > 0.0f), outside = !(cone > 0.0f);
        int lit = outside ? LIGHT_OUT_OF_CONE : LIGHT_TRACED;
        out->skip[i] = below ? LIGHT_BELOW_HORIZON : far ? LIGHT_OUT_OF_RANGE : lit;
        out->irradiance[i] = cone * cone * window * (shading * inverse) / squared;
        out->density[i] = 0.0f;
        out->rays.ray.dir_x[i] = c[0] - r->origin.x[i];
        out->rays.ray.dir_y[i] = c[1] - r->origin.y[i];
        out->rays.ray.dir_z[i] = c[2] - r->origin.z[i];
    }
}

static void sample_directional(const struct light *light, const struct surface *restrict r,
                               struct light_packet *restrict out)
{
    const float *d = light->plan->direction;
    for (int i = 0; i < LANES; i++) {
        float shading = -(d[0] * r->normal.x[i] + d[1] * r->normal.y[i] + d[2] * r->normal.z[i]);
        float facet = -(d[0] * r->facet.x[i] + d[1] * r->facet.y[i] + d[2] * r->facet.z[i]);
        int below = !((shading > 0.0f) & (facet > 0.0f));
        out->skip[i] = below ? LIGHT_BELOW_HORIZON : LIGHT_TRACED;
        out->irradiance[i] = shading;
        out->density[i] = 0.0f;
        out->rays.ray.dir_x[i] = -d[0];
        out->rays.ray.dir_y[i] = -d[1];
        out->rays.ray.dir_z[i] = -d[2];
    }
}

/* Origins, ends, and which lanes go to Embree. Comparisons are false for NaN. */
static void finish_packet(const struct surface *restrict r, const struct lanes_mask *restrict lanes,
                          struct light_packet *restrict out)
{
    struct RTCRay16 *ray = &out->rays.ray;
    for (int i = 0; i < LANES; i++) {
        float x = r->origin.x[i], y = r->origin.y[i], z = r->origin.z[i];
        int fit = (fabsf(x) < ORIGIN_MAX) & (fabsf(y) < ORIGIN_MAX) & (fabsf(z) < ORIGIN_MAX) &
                  (fabsf(ray->dir_x[i]) < INFINITY) & (fabsf(ray->dir_y[i]) < INFINITY) &
                  (fabsf(ray->dir_z[i]) < INFINITY) & (out->irradiance[i] < INFINITY);
        int skip = out->skip[i];
        skip = ((skip == LIGHT_TRACED) & !fit) ? LIGHT_NOT_FINITE : skip;
        out->skip[i] = skip;
        out->traced.on[i] = skip == LIGHT_TRACED ? lanes->on[i] : 0;
        ray->org_x[i] = x;
        ray->org_y[i] = y;
        ray->org_z[i] = z;
        ray->tfar[i] = out->end;
    }
}

static void kernel_sample_light(const struct light *light, const float *u, const float *v,
                                const struct surface *receiver, const struct lanes_mask *lanes,
                                struct light_packet *out)
{
    out->end = SHADOW_END;
    switch ((enum light_type)light->plan->type) {
    case LIGHT_POINT:
    case LIGHT_SPOT:
        sample_point(light, receiver, out);
        break;
    case LIGHT_DIRECTIONAL:
        sample_directional(light, receiver, out);
        out->end = INFINITY;
        break;
    case LIGHT_RECTANGLE:
        sample_rectangle(light, u, v, receiver, true, out);
        if (light->plan->profile == PROFILE_GAUSSIAN) apply_profile(u, v, out);
        break;
    }
    finish_packet(receiver, lanes, out);
}

static void kernel_sample_stratum(const struct light *light, const float *u, const float *v,
                                  const struct surface *receiver, const struct lanes_mask *lanes,
                                  struct light_packet *out)
{
    if (light->plan->type != LIGHT_RECTANGLE) {
        kernel_sample_light(light, u, v, receiver, lanes, out);
        return;
    }
    out->end = SHADOW_END;
    sample_rectangle(light, u, v, receiver, false, out);
    if (light->plan->profile == PROFILE_GAUSSIAN) apply_profile(u, v, out);
    finish_packet(receiver, lanes, out);
}

/* The largest product of a direction with the ways to a rectangle's corners, given the product with
 * the way to its centre, and with its half sides. */
static inline float reach(float centre, float u, float v)
{
    return centre + fabsf(u) + fabsf(v);
}

/* A rectangle lies below a plane when all its corners do, and a receiver behind its plane is behind
 * all of it. What only the facet hides is sampled: its strata count as blocked. */
static bool kernel_light_hidden(const struct light *light, const struct surface *restrict r,
                                const struct lanes_mask *restrict lanes,
                                struct light_packet *restrict out)
{
    const struct plan_light *p = light->plan;
    const float *c = p->position, *u = p->half_u, *v = p->half_v, *d = p->direction;
    int32_t open = 0;
    if (p->type != LIGHT_RECTANGLE) return false;
    for (int i = 0; i < LANES; i++) {
        float wx = c[0] - r->position.x[i], wy = c[1] - r->position.y[i];
        float wz = c[2] - r->position.z[i];
        float nx = r->normal.x[i], ny = r->normal.y[i], nz = r->normal.z[i];
        float fx = r->facet.x[i], fy = r->facet.y[i], fz = r->facet.z[i];
        float nu = nx * u[0] + ny * u[1] + nz * u[2], nv = nx * v[0] + ny * v[1] + nz * v[2];
        float fu = fx * u[0] + fy * u[1] + fz * u[2], fv = fx * v[0] + fy * v[1] + fz * v[2];
        float shading = wx * nx + wy * ny + wz * nz, facet = wx * fx + wy * fy + wz * fz;
        int below = !(reach(shading, nu, nv) > 0.0f);
        int above = (-reach(-shading, nu, nv) > 0.0f) & (-reach(-facet, fu, fv) > 0.0f);
        int behind = above & !(-(wx * d[0] + wy * d[1] + wz * d[2]) > 0.0f);
        out->skip[i] = below ? LIGHT_BELOW_HORIZON : behind ? LIGHT_FACING_AWAY : LIGHT_TRACED;
        open |= (below | behind) ? 0 : lanes->on[i];
    }
    return open == 0;
}
