#pragma once
/* The blur of shadow_kernels. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/shadow/compatible_lanes.h"
#include "server/reconstruct/simd/gaussian_lanes.h"
#include "server/reconstruct/simd/inline.h"

#define BLUR_TOGETHER 16 /* taps that are met before any is weighed */

/* Computes exponents of SIMD_LANES pixels' weights at tap k; infinite where they refuse it. */
SIMD_INLINE void blur_meet(const struct shadow_blur *f, int32_t step, size_t at, int32_t k,
                           float out[SIMD_LANES])
{
    const struct shadow_pixels *pixels = f->pixels;
    const float *px = pixels->point[0], *py = pixels->point[1], *pz = pixels->point[2];
    const float *nx = pixels->normal[0], *ny = pixels->normal[1], *nz = pixels->normal[2];
    const float *plane_min = pixels->plane_min, *distance_most2 = pixels->distance_most2;
    const float *falloff = f->falloff, *refusal = f->refusal;
    const int32_t *reach = f->reach, beyond = (k < 0 ? -k : k) - 1;
    const size_t to = (size_t)((ptrdiff_t)at + (ptrdiff_t)k * step);
    for (size_t lane = 0; lane < SIMD_LANES; lane++) {
        const size_t p = at + lane, q = to + lane;
        const struct compatible_receiver receiver = {
            {px[p], py[p], pz[p]}, {nx[p], ny[p], nz[p]}, plane_min[p], distance_most2[p]};
        float squared;
        const int32_t same =
            compatible_point(&receiver, px[q], py[q], pz[q], nx[q], ny[q], nz[q], &squared);
        const float exponent = squared * falloff[p];
        const int32_t kept =
            same & (reach[p] > beyond) & (exponent <= SHADOW_AXIS_CUT) & (squared <= refusal[q]);
        out[lane] = kept ? exponent : INFINITY;
    }
}

/* Adds `count` taps, the first of which reads `values`, to the sums of weighted values and of
 * weights. */
SIMD_INLINE void blur_add(float (*exponents)[SIMD_LANES], int32_t count, const float *values,
                          ptrdiff_t step, struct simd *sum, struct simd *weights)
{
    for (int v = 0; v < SIMD_VECTORS; v++) {
        const size_t aside = (size_t)v * SIMD_PER_VECTOR;
        simd_vector all = sum->v[v], whole = weights->v[v];
        for (int32_t k = 0; k < count; k++) {
            const simd_vector w = gaussian_exp_minus_lanes(simd_load_vector(exponents[k] + aside));
            all = simd_fused(w, simd_load_vector(values + k * step + aside), all);
            whole += w;
        }
        sum->v[v] = all, weights->v[v] = whole;
    }
}

/* Blurs SIMD_LANES adjacent pixels from `at` on, with `most` taps to both sides. */
static inline void blur_group(const struct shadow_blur *f, int32_t step, size_t at, int32_t most,
                              float out[SIMD_LANES])
{
    const float *seen = f->seen + at;
    _Alignas(64) float exponents[BLUR_TOGETHER][SIMD_LANES];
    struct simd sum = simd_all(0.0f), weights = sum;
    for (int32_t first = -most, n; first <= most; first += n) {
        const int32_t left = most + 1 - first;
        n = left < BLUR_TOGETHER ? left : BLUR_TOGETHER;
        for (int32_t k = 0; k < n; k++) blur_meet(f, step, at, first + k, exponents[k]);
        blur_add(exponents, n, seen + (ptrdiff_t)first * step, step, &sum, &weights);
    }
    for (int v = 0; v < SIMD_VECTORS; v++) {
        const size_t aside = (size_t)v * SIMD_PER_VECTOR;
        const simd_vector all = weights.v[v], one = simd_same(1.0f);
        const simd_vector mean = sum.v[v] / simd_select(all > 0.0f, all, one);
        *(simd_stored *)(out + aside) =
            simd_select(all > 0.0f, mean, simd_load_vector(seen + aside));
    }
}

static void kernel_blur(const struct shadow_blur *f, int32_t step, size_t first, uint32_t count,
                        float *out)
{
    for (uint32_t i = 0; i < count; i += SIMD_LANES) {
        const uint32_t left = count - i, n = left < SIMD_LANES ? left : SIMD_LANES;
        int32_t most = 0;
        _Alignas(64) float group[SIMD_LANES];
        for (uint32_t k = 0; k < n; k++)
            most = most > f->reach[first + i + k] ? most : f->reach[first + i + k];
        if (most > 0)
            blur_group(f, step, first + i, most, group);
        else
            memcpy(group, f->seen + first + i, n * sizeof *group);
        memcpy(out + i, group, n * sizeof *group);
    }
}
