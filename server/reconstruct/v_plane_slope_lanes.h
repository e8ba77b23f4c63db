#pragma once
/* v_plane_kernels' strata, slopes, average and records: pixels of a row side by side, in plain
 * loops that the compiler vectorises. */
#include <math.h>
#include <string.h>

#include "proto/pattern.h"
#include "proto/v_plane.h"
#include "server/reconstruct/v_plane_kernels.h"

#define V_PLANE_TURN 6.28318531f

static inline float v_plane_stratum(float jitter, uint32_t l, uint32_t k)
{
    const float in =
        ((float)k + (jitter < PATTERN_JITTER_MAX ? jitter : PATTERN_JITTER_MAX)) / (float)l;
    const float low = in > V_PLANE_END ? in : V_PLANE_END;
    return low < 1.0f - V_PLANE_END ? low : 1.0f - V_PLANE_END;
}

/* The cube root of x > 0 by a third of its exponent and Newton's steps, to the float's digits. */
static inline float v_plane_cube_root(float x)
{
    uint32_t bits;
    float r;
    memcpy(&bits, &x, sizeof bits);
    bits = bits / 3 + 0x2a5119f2u;
    memcpy(&r, &bits, sizeof r);
    for (int i = 0; i < 3; i++) r += (x / (r * r) - r) * (1.0f / 3);
    return r;
}

/* Sine and cosine of theta / 2 with theta + sin theta = pi (2 v - 1). With e = pi - |theta|, q = e
 * - sin e = 2 pi min(v, 1 - v) and r = (6 q)^(1/3), sin(e/2) / r and cos(e/2) are smooth in r^2:
 * polynomials through Chebyshev's points of [0, (6 pi)^(2/3)], errors of 2e-6. */
static inline void v_plane_turn(float v, float *sine, float *cosine)
{
    const float rest = v < 0.5f ? v : 1.0f - v;
    const float r = v_plane_cube_root(6.0f * V_PLANE_TURN * rest), s = r * r;
    float a = -7.08597701e-8f, b = -1.17282310e-7f;
    a = a * s + 8.22200095e-7f;
    b = b * s + 1.27012153e-6f;
    a = a * s - 6.59736996e-6f;
    b = b * s - 1.15529153e-5f;
    a = a * s - 7.59296824e-6f;
    b = b * s - 3.85386801e-5f;
    a = a * s - 4.42152837e-4f;
    b = b * s - 1.59102468e-3f;
    a = a * s - 1.24917729e-2f;
    b = b * s - 1.24987011e-1f;
    a = a * s + 4.99999402e-1f;
    b = b * s + 9.99999056e-1f;
    *sine = v < 0.5f ? -b : b;
    *cosine = r * a;
}

static void kernel_strata(const struct v_plane_strata *s, const float *jitter_u,
                          const float *jitter_v)
{
    for (uint32_t i = 0; i < s->l; i++) {
        float *height = s->height + i * s->stride;
        float *sine = s->sine + i * s->stride, *cosine = s->cosine + i * s->stride;
        for (uint32_t k = 0; k < s->count; k++) {
            const float u = v_plane_stratum(jitter_u[k], s->l, i);
            height[k] = 2.0f * sqrtf(u * (1.0f - u));
        }
        for (uint32_t k = 0; k < s->count; k++)
            v_plane_turn(v_plane_stratum(jitter_v[k], s->l, i), &sine[k], &cosine[k]);
    }
}

/* What sixteen pixels' samples add up to. */
struct v_plane_sums {
    float weight[V_PLANE_LANES], mean[V_PLANE_LANES], square[V_PLANE_LANES];
};

static inline void v_plane_add_slopes(const struct v_plane_strata *s,
                                      const struct v_plane_planes *planes, uint32_t i, uint32_t at,
                                      uint32_t count, const float *inverse, float least,
                                      struct v_plane_sums *sums)
{
    const float *sample = planes->first + 4 * (size_t)i * planes->stride + at;
    const float *r = sample, *g = r + planes->stride, *b = g + planes->stride;
    const float *t = b + planes->stride;
    const float *height = s->height + i % s->l * s->stride + at;
    const float *cosine = s->cosine + i / s->l * s->stride + at;
    for (uint32_t k = 0; k < count; k++) {
        const float z = height[k] * cosine[k], up = t[k] * inverse[k] * z;
        const int32_t hit = t[k] > 0.0f;
        const int32_t bright = (r[k] > 0.0f) | (g[k] > 0.0f) | (b[k] > 0.0f);
        const float met = 1.0f / (up > least ? up : least);
        const float a = hit ? met : 0.0f, w = hit | bright ? z * z : 0.0f;
        sums->weight[k] += w;
        sums->mean[k] += w * a;
        sums->square[k] += w * a * a;
    }
}

static void kernel_slopes(const struct v_plane_strata *s, const struct v_plane_planes *planes,
                          const struct v_plane_source *sources, float least_px, float *mean,
                          float *deviation)
{
    for (uint32_t at = 0; at < s->count; at += V_PLANE_LANES) {
        const uint32_t left = s->count - at, n = left < V_PLANE_LANES ? left : V_PLANE_LANES;
        struct v_plane_sums sums = {{0}, {0}, {0}};
        float inverse[V_PLANE_LANES];
        for (uint32_t k = 0; k < n; k++) /* sizes are not 0 where something was measured */
            inverse[k] = sources[at + k].pixel > 0.0f ? 1.0f / sources[at + k].pixel : 0.0f;
        for (uint32_t i = 0; i < s->l * s->l; i++)
            v_plane_add_slopes(s, planes, i, at, n, inverse, least_px, &sums);
        for (uint32_t k = 0; k < n; k++) {
            const int32_t any = (sums.weight[k] > 0.0f) & (inverse[k] > 0.0f);
            const float scale = any ? 1.0f / sums.weight[k] : 0.0f;
            const float m = sums.mean[k] * scale, square = sums.square[k] * scale - m * m;
            mean[at + k] = any ? m : -1.0f;
            deviation[at + k] = any && square > 0.0f ? sqrtf(square) : 0.0f;
        }
    }
}

static void kernel_average(const struct v_plane_slopes_field *in, size_t first, uint32_t count,
                           float *mean, float *deviation)
{
    const float *x = in->normal[0], *y = in->normal[1], *z = in->normal[2];
    const float *const own_mean = in->mean, *const own_deviation = in->deviation;
    const int32_t *object = in->object;
    for (uint32_t at = 0; at < count; at += V_PLANE_LANES) {
        const uint32_t left = count - at, n = left < V_PLANE_LANES ? left : V_PLANE_LANES;
        const size_t p = first + at;
        float m[V_PLANE_LANES] = {0}, d[V_PLANE_LANES] = {0}, counts[V_PLANE_LANES] = {0};
        for (int32_t v = -V_PLANE_SLOPES_PX; v <= V_PLANE_SLOPES_PX; v++) {
            for (int32_t u = -V_PLANE_SLOPES_PX; u <= V_PLANE_SLOPES_PX; u++) {
                const size_t q = (size_t)((ptrdiff_t)p + (ptrdiff_t)v * in->width + u);
                for (uint32_t k = 0; k < n; k++) {
                    const float alike =
                        x[p + k] * x[q + k] + y[p + k] * y[q + k] + z[p + k] * z[q + k];
                    const int32_t same = (object[q + k] == object[p + k]) &
                                         (own_mean[q + k] >= 0.0f) & (alike >= V_PLANE_COS_NORMALS);
                    m[k] += same ? own_mean[q + k] : 0.0f;
                    d[k] += same ? own_deviation[q + k] : 0.0f;
                    counts[k] += same ? 1.0f : 0.0f;
                }
            }
        }
        for (uint32_t k = 0; k < n; k++) {
            const float scale = counts[k] > 0.0f ? 1.0f / counts[k] : 0.0f;
            mean[p + k] = m[k] * scale;
            deviation[p + k] = d[k] * scale;
        }
    }
}

static void kernel_records(const struct v_plane_strata *s, const struct v_plane_planes *planes,
                           uint32_t lanes, const uint8_t *needs, uint8_t mask, float scale,
                           float *out)
{
    const size_t size = V_PLANE_RECORD * (size_t)lanes, stride = planes->stride;
    for (uint32_t i = 0; i < s->l * s->l; i++) {
        const float *sample = planes->first + 4 * (size_t)i * stride;
        const float *height = s->height + i % s->l * s->stride;
        const float *sine = s->sine + i / s->l * s->stride;
        const float *cosine = s->cosine + i / s->l * s->stride;
        float *to = out + i / s->l * v_plane_row_lanes(s->l) + i % s->l;
        for (uint32_t k = 0; k < s->count; k++, to += size) {
            if (!(needs[k] & mask)) continue;
            const float z = height[k] * cosine[k];
            to[0] = 2.0f * sine[k] * z;
            to[lanes] = z * z;
            to[2 * lanes] = cosine[k] * cosine[k];
            to[3 * lanes] = sample[k] * scale;
            to[4 * lanes] = sample[stride + k] * scale;
            to[5 * lanes] = sample[2 * stride + k] * scale;
        }
    }
}
