#pragma once
/* v_plane_kernels' strata, slopes, average and records: pixels of a row side by side, in
 * vectors or plain loops that the compiler vectorises. */
#include <math.h>
#include <string.h>

#include "proto/pattern.h"
#include "proto/v_plane.h"
#include "server/reconstruct/indirect/v_plane_kernels.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

#define V_PLANE_TURN 6.28318531f

static inline float v_plane_stratum(float jitter, uint32_t l, uint32_t k)
{
    const float in =
        ((float)k + (jitter < PATTERN_JITTER_MAX ? jitter : PATTERN_JITTER_MAX)) / (float)l;
    const float low = in > V_PLANE_END ? in : V_PLANE_END;
    return low < 1.0f - V_PLANE_END ? low : 1.0f - V_PLANE_END;
}

/* Returns the cube root of x > 0, from a third of its exponent by Newton's steps, to the float's
 * digits. */
static inline float v_plane_cube_root(float x)
{
    uint32_t bits;
    float r;
    memcpy(&bits, &x, sizeof bits);
    bits = bits / 3 + 0x2a5119f2u;
    memcpy(&r, &bits, sizeof r);
    for (int i = 0; i < 3; i++) r = fused(x / (r * r) - r, 1.0f / 3, r);
    return r;
}

/* Computes the sine and cosine of theta / 2 with theta + sin theta = pi (2 v - 1). With e = pi -
 * |theta|, q = e - sin e = 2 pi min(v, 1 - v) and r = (6 q)^(1/3), sin(e/2) / r and cos(e/2) are
 * smooth in r^2: polynomials through Chebyshev's points of [0, (6 pi)^(2/3)], errors of 2e-6. */
static inline void v_plane_turn(float v, float *sine, float *cosine)
{
    const float rest = v < 0.5f ? v : 1.0f - v;
    const float r = v_plane_cube_root(6.0f * V_PLANE_TURN * rest), s = r * r;
    float a = -7.08597701e-8f, b = -1.17282310e-7f;
    a = fused(a, s, 8.22200095e-7f);
    b = fused(b, s, 1.27012153e-6f);
    a = fused(a, s, -6.59736996e-6f);
    b = fused(b, s, -1.15529153e-5f);
    a = fused(a, s, -7.59296824e-6f);
    b = fused(b, s, -3.85386801e-5f);
    a = fused(a, s, -4.42152837e-4f);
    b = fused(b, s, -1.59102468e-3f);
    a = fused(a, s, -1.24917729e-2f);
    b = fused(b, s, -1.24987011e-1f);
    a = fused(a, s, 4.99999402e-1f);
    b = fused(b, s, 9.99999056e-1f);
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

/* Loads the first `n` lanes, in one piece where the compiler knows that these are all; 0 beyond. */
SIMD_INLINE simd_vector v_plane_load(const float *from, size_t n)
{
    simd_vector out = {0};
    memcpy(&out, from, n * sizeof *from);
    return out;
}

SIMD_INLINE simd_mask v_plane_load_mask(const int32_t *from, size_t n)
{
    simd_mask out = {0};
    memcpy(&out, from, n * sizeof *from);
    return out;
}

/* Sums over pixels' samples. */
struct v_plane_sums {
    simd_vector weight, mean, square;
};

/* Adds stratum (column, row) of `n` pixels from `at` on. */
SIMD_INLINE void v_plane_add_slopes(const struct v_plane_strata *s,
                                    const struct v_plane_planes *planes, uint32_t column,
                                    uint32_t row, size_t at, size_t n, simd_vector inverse,
                                    float least, struct v_plane_sums *sums)
{
    const float *r = planes->first + 4 * (size_t)(row * s->l + column) * planes->stride + at;
    const float *g = r + planes->stride, *b = g + planes->stride;
    const simd_vector t = v_plane_load(b + planes->stride, n), lowest = simd_all(least).v[0];
    const simd_vector z = v_plane_load(s->height + column * s->stride + at, n) *
                          v_plane_load(s->cosine + row * s->stride + at, n);
    const simd_vector up = t * inverse * z, met = 1.0f / simd_select(up > lowest, up, lowest);
    const simd_mask hit = t > 0.0f, bright = (v_plane_load(r, n) > 0.0f) |
                                             (v_plane_load(g, n) > 0.0f) |
                                             (v_plane_load(b, n) > 0.0f);
    const simd_vector a = simd_where(hit, met), w = simd_where(hit | bright, z * z);
    sums->weight += w;
    sums->mean = simd_fused(w, a, sums->mean);
    sums->square = simd_fused(w * a, a, sums->square);
}

/* Computes the slopes of `n` pixels from `at` on, a vector at most. */
SIMD_INLINE void v_plane_slopes_vector(const struct v_plane_strata *s,
                                       const struct v_plane_planes *planes,
                                       const struct v_plane_source *sources, float least_px,
                                       size_t at, size_t n, float *mean, float *deviation)
{
    const simd_vector zero = {0}, one = simd_all(1.0f).v[0];
    struct v_plane_sums sums = {zero, zero, zero};
    float pixel[SIMD_PER_VECTOR] = {0};
    for (size_t k = 0; k < n; k++) pixel[k] = sources[at + k].pixel;
    const simd_vector size = simd_load_vector(pixel);
    const simd_mask measured = size > 0.0f; /* then it is not 0 */
    const simd_vector inverse = simd_where(measured, one / simd_select(measured, size, one));
    for (uint32_t row = 0; row < s->l; row++)
        for (uint32_t column = 0; column < s->l; column++)
            v_plane_add_slopes(s, planes, column, row, at, n, inverse, least_px, &sums);
    const simd_mask any = (sums.weight > 0.0f) & (inverse > 0.0f);
    const simd_vector scale = simd_where(any, one / simd_select(any, sums.weight, one));
    const simd_vector m = sums.mean * scale, square = simd_fused(sums.square, scale, -m * m);
    const simd_vector root = simd_root(simd_where(any & (square > 0.0f), square));
    const simd_vector answer = simd_select(any, m, zero - one);
    memcpy(mean + at, &answer, n * sizeof *mean);
    memcpy(deviation + at, &root, n * sizeof *deviation);
}

static void kernel_slopes(const struct v_plane_strata *s, const struct v_plane_planes *planes,
                          const struct v_plane_source *sources, float least_px, float *mean,
                          float *deviation)
{
    size_t at = 0;
    for (; at + SIMD_PER_VECTOR <= s->count; at += SIMD_PER_VECTOR)
        v_plane_slopes_vector(s, planes, sources, least_px, at, SIMD_PER_VECTOR, mean, deviation);
    if (at < s->count)
        v_plane_slopes_vector(s, planes, sources, least_px, at, s->count - at, mean, deviation);
}

/* Averages around `n` pixels from p on, a vector at most. */
SIMD_INLINE void v_plane_average_vector(const struct v_plane_slopes_field *in, size_t p, size_t n,
                                        float *mean, float *deviation)
{
    const float *const *normal = in->normal;
    const simd_vector own[3] = {v_plane_load(normal[0] + p, n), v_plane_load(normal[1] + p, n),
                                v_plane_load(normal[2] + p, n)};
    const simd_mask object = v_plane_load_mask(in->object + p, n);
    simd_vector m = {0}, d = {0};
    simd_mask counts = {0};
    for (int32_t v = -V_PLANE_SLOPES_PX; v <= V_PLANE_SLOPES_PX; v++) {
        for (int32_t u = -V_PLANE_SLOPES_PX; u <= V_PLANE_SLOPES_PX; u++) {
            const size_t q = (size_t)((ptrdiff_t)p + (ptrdiff_t)v * in->width + u);
            const simd_vector other[3] = {v_plane_load(normal[0] + q, n),
                                          v_plane_load(normal[1] + q, n),
                                          v_plane_load(normal[2] + q, n)};
            const simd_vector alike = simd_dot(own, other);
            const simd_vector near = v_plane_load(in->mean + q, n);
            const simd_mask same = (v_plane_load_mask(in->object + q, n) == object) &
                                   (near >= 0.0f) & (alike >= V_PLANE_COS_NORMALS);
            m += simd_where(same, near);
            d += simd_where(same, v_plane_load(in->deviation + q, n));
            counts -= same;
        }
    }
    const simd_mask none = counts == 0; /* then sums are 0 */
    const simd_vector scale = 1.0f / __builtin_convertvector(counts - none, simd_vector);
    m *= scale;
    d *= scale;
    memcpy(mean + p, &m, n * sizeof *mean);
    memcpy(deviation + p, &d, n * sizeof *deviation);
}

static void kernel_average(const struct v_plane_slopes_field *in, size_t first, uint32_t count,
                           float *mean, float *deviation)
{
    size_t at = 0;
    for (; at + SIMD_PER_VECTOR <= count; at += SIMD_PER_VECTOR)
        v_plane_average_vector(in, first + at, SIMD_PER_VECTOR, mean, deviation);
    if (at < count) v_plane_average_vector(in, first + at, count - at, mean, deviation);
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
