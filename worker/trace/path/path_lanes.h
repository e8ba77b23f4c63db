#pragma once
/* The inner loops of the path tracer, for path_kernels. */
#include <math.h>

#include "proto/pattern_path.h"
#include "worker/shade/lambert.h"
#include "worker/trace/light/gaussian_lanes.h"
#include "worker/trace/path/mis.h"
#include "worker/trace/path/path.h"

#define PATH_INVERSE_PI 0.318309886183790672f

static void kernel_path_pairs_of(const uint32_t *restrict key, const uint32_t *restrict sample,
                                 uint32_t dimension, float *restrict u, float *restrict v)
{
    for (int i = 0; i < LANES; i++) path_pair(key[i], sample[i], dimension, &u[i], &v[i]);
}

static void kernel_path_pairs(const struct path_packet *restrict p, uint32_t dimension,
                              float *restrict u, float *restrict v)
{
    for (int i = 0; i < LANES; i++) path_pair(p->key[i], p->sample[i], dimension, &u[i], &v[i]);
}

static void kernel_frame_pairs(uint32_t key, const uint32_t *restrict sample, uint32_t dimension,
                               float *restrict u, float *restrict v)
{
    for (int i = 0; i < LANES; i++) path_pair(key, sample[i], dimension, &u[i], &v[i]);
}

static void kernel_ray_keys(const struct path_packet *restrict p, uint32_t depth, enum path_ray ray,
                            struct RTCRay16 *restrict r)
{
    for (int i = 0; i < LANES; i++) r->id[i] = path_ray_key(p->key[i], p->sample[i], depth, ray);
}

/* Turns pinhole rays into rays through the points (s, t) of a lens of radius 1. */
static void kernel_lens_rays(const struct plan_camera *c, const float *restrict s,
                             const float *restrict t, struct RTCRay16 *restrict r)
{
    const float *right = c->right, *up = c->up, *ahead = c->forward;
    for (int i = 0; i < LANES; i++) {
        float along = r->dir_x[i] * ahead[0] + r->dir_y[i] * ahead[1] + r->dir_z[i] * ahead[2];
        /* Pinhole rays are forward + a right + b up, scaled: along is positive. */
        float reach = c->focus_distance / along;
        float a = s[i] * c->aperture_radius, b = t[i] * c->aperture_radius;
        float ox = a * right[0] + b * up[0], oy = a * right[1] + b * up[1];
        float oz = a * right[2] + b * up[2];
        float x = reach * r->dir_x[i] - ox, y = reach * r->dir_y[i] - oy;
        float z = reach * r->dir_z[i] - oz;
        float scale = 1.0f / sqrtf(x * x + y * y + z * z); /* at least focus_distance long */
        r->org_x[i] += ox;
        r->org_y[i] += oy;
        r->org_z[i] += oz;
        r->dir_x[i] = x * scale;
        r->dir_y[i] = y * scale;
        r->dir_z[i] = z * scale;
    }
}

/* Computes right-handed tangents of unit normals (Duff et al. 2017, "Building an orthonormal basis,
 * revisited"). */
static void kernel_tangents(const struct lanes3 *restrict n, struct lanes3 *restrict t,
                            struct lanes3 *restrict b)
{
    for (int i = 0; i < LANES; i++) {
        float sign = copysignf(1.0f, n->z[i]);
        float a = -1.0f / (sign + n->z[i]), c = n->x[i] * n->y[i] * a; /* |sign + z| >= 1 */
        t->x[i] = 1.0f + sign * n->x[i] * n->x[i] * a;
        t->y[i] = sign * c;
        t->z[i] = -sign * n->x[i];
        b->x[i] = c;
        b->y[i] = sign + n->y[i] * n->y[i] * a;
        b->z[i] = -n->y[i];
    }
}

/* Samples cosine-distributed directions around the shading normals. Lanes whose direction lies
 * below the facet leave *valid. */
static void kernel_lambert_scatter(const struct surface *restrict s, const float *restrict u,
                                   const float *restrict v, struct lanes_mask *restrict valid,
                                   struct lanes3 *restrict out, float *restrict pdf)
{
    struct lanes3 t, b, local;
    kernel_tangents(&s->normal, &t, &b);
    for (int i = 0; i < LANES; i++)
        lambert_direction(u[i], v[i], &local.x[i], &local.y[i], &local.z[i]);
    for (int i = 0; i < LANES; i++) {
        float x = local.x[i], y = local.y[i], z = local.z[i];
        out->x[i] = x * t.x[i] + y * b.x[i] + z * s->normal.x[i];
        out->y[i] = x * t.y[i] + y * b.y[i] + z * s->normal.y[i];
        out->z[i] = x * t.z[i] + y * b.z[i] + z * s->normal.z[i];
        float facet =
            out->x[i] * s->facet.x[i] + out->y[i] * s->facet.y[i] + out->z[i] * s->facet.z[i];
        valid->on[i] &= -((facet > 0.0f) & (z > 0.0f));
        pdf[i] = z * PATH_INVERSE_PI;
    }
}

LANE_INLINE void play_roulette(float chance, float promise, int i, struct lanes3 *t,
                               struct lanes_mask *stays)
{
    float most = t->x[i] > t->y[i] ? t->x[i] : t->y[i];
    most = promise * (most > t->z[i] ? most : t->z[i]);
    float stay = most < PATH_ROULETTE_MAX ? most : PATH_ROULETTE_MAX;
    stay = chance < 0.0f ? 1.0f : stay;
    const float over = stay > 0.0f ? stay : 1.0f; /* else none stays */
    stays->on[i] = -!(chance >= stay);
    t->x[i] /= over;
    t->y[i] /= over;
    t->z[i] /= over;
}

static void kernel_weigh_segments(const struct path_packet *restrict p,
                                  const struct path_scattering *restrict s,
                                  const float *restrict chance, struct lanes3 *restrict throughput,
                                  struct lanes_mask *restrict stays)
{
    for (int i = 0; i < LANES; i++) {
        throughput->x[i] = p->throughput.x[i] * s->weight.x[i];
        throughput->y[i] = p->throughput.y[i] * s->weight.y[i];
        throughput->z[i] = p->throughput.z[i] * s->weight.z[i];
    }
    for (int i = 0; !chance && i < LANES; i++) stays->on[i] = -1;
    for (int i = 0; chance && i < LANES; i++)
        play_roulette(chance[i], s->promise[i], i, throughput, stays);
}

/* Computes the radiance that Lambert surfaces of albedo 1 reflect of visible light samples. The
 * packet's densities are those of the light alone. out = color E / pi * weight */
static void kernel_lambert_light(const struct nee_sample *restrict l,
                                 const struct surface *restrict s,
                                 const float *restrict probability, struct lanes3 *restrict out)
{
    const struct RTCRay16 *r = &l->packet.rays.ray;
    for (int i = 0; i < LANES; i++) {
        float x = r->dir_x[i], y = r->dir_y[i], z = r->dir_z[i];
        float squared = x * x + y * y + z * z;
        float cosine = (x * s->normal.x[i] + y * s->normal.y[i] + z * s->normal.z[i]) /
                       sqrtf(squared > 0.0f ? squared : 1.0f);
        float weight =
            mis_power_weight(l->packet.density[i] * probability[i], cosine * PATH_INVERSE_PI);
        float e = l->packet.irradiance[i] * PATH_INVERSE_PI * weight;
        out->x[i] = e * l->color.x[i];
        out->y[i] = e * l->color.y[i];
        out->z[i] = e * l->color.z[i];
    }
}

/* Computes the factor of a rectangle's color along scattered rays that end at `reach`, 0 where a
 * ray misses the rectangle, and the density of its light samples. */
static void kernel_meet_rectangle(const struct light *light, const struct path_packet *restrict p,
                                  const float *restrict reach, float *restrict profile,
                                  float *restrict density)
{
    const struct plan_light *q = light->plan;
    const float *c = q->position, *n = q->direction, *hu = q->half_u, *hv = q->half_v;
    const float uu = hu[0] * hu[0] + hu[1] * hu[1] + hu[2] * hu[2];
    const float vv = hv[0] * hv[0] + hv[1] * hv[1] + hv[2] * hv[2];
    const float inverse_u = 1.0f / uu, inverse_v = 1.0f / vv; /* plan_decode: not degenerate */
    const int gaussian_profile = q->profile == PROFILE_GAUSSIAN;
    const struct RTCRay16 *r = &p->rays.ray;
    for (int i = 0; i < LANES; i++) {
        float dx = r->dir_x[i], dy = r->dir_y[i], dz = r->dir_z[i];
        float wx = c[0] - r->org_x[i], wy = c[1] - r->org_y[i], wz = c[2] - r->org_z[i];
        float cosine = -(dx * n[0] + dy * n[1] + dz * n[2]);
        float height = -(wx * n[0] + wy * n[1] + wz * n[2]);
        int faces = (cosine > 1e-12f) & (height > 0.0f);
        float t = height / (faces ? cosine : 1.0f);
        float x = t * dx - wx, y = t * dy - wy, z = t * dz - wz;
        float a = (x * hu[0] + y * hu[1] + z * hu[2]) * inverse_u;
        float b = (x * hv[0] + y * hv[1] + z * hv[2]) * inverse_v;
        int inside = faces & (fabsf(a) <= 1.0f) & (fabsf(b) <= 1.0f) & (t <= reach[i]);
        float square = a * a + b * b;
        float bright = gaussian_profile ? gaussian(2.0f * (square < 2.0f ? square : 2.0f)) : 1.0f;
        density[i] = (t * t) / ((faces ? cosine : 1.0f) * light->area);
        profile[i] = inside ? bright : 0.0f;
    }
}
