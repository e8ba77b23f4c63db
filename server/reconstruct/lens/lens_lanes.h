#pragma once
/* The lens_kernels that gather, a vector of pixels at a time. Whatever instruction set the
 * including file is compiled for, each pixel sees the same operations in the same order. */
#include <string.h>

#include "proto/lens_pattern.h"
#include "server/reconstruct/lens/lens_cell_lanes.h"
#include "server/reconstruct/lens/lens_kernels.h"
#include "server/reconstruct/lens/lens_layer.h"
#include "server/reconstruct/lens/lens_line_lanes.h"
#include "server/reconstruct/simd/vector.h"

/* Returns reach - distance, clamped to 0 .. 1. */
static inline simd_vector lens_covered(simd_vector reach, float distance)
{
    const simd_vector zero = {0}, one = 1.0f - zero, in = reach - distance;
#ifdef __AVX512F__
    return (simd_vector)_mm512_min_ps(_mm512_max_ps((__m512)in, (__m512)zero), (__m512)one);
#elif defined __AVX__
    return (simd_vector)_mm256_min_ps(_mm256_max_ps((__m256)in, (__m256)zero), (__m256)one);
#else
    return (simd_vector)_mm_min_ps(_mm_max_ps((__m128)in, (__m128)zero), (__m128)one);
#endif
}

/* Returns whether any of the numbers, which are not below 0, is above 0. */
static inline int lens_is_any(simd_vector numbers)
{
#ifdef __AVX512F__
    return _mm512_test_epi32_mask((__m512i)numbers, (__m512i)numbers) != 0;
#elif defined __AVX__
    return !_mm256_testz_si256((__m256i)numbers, (__m256i)numbers);
#else
    return _mm_movemask_ps((__m128)(numbers > 0.0f)) != 0;
#endif
}

/* The number of vectors that are summed at once, as many as registers hold sums of. */
#ifdef __AVX512F__
#define LENS_VECTORS 1
#elif defined __AVX__
#define LENS_VECTORS 2
#else
#define LENS_VECTORS 1
#endif

struct lens_sums {
    simd_vector v[LENS_VECTORS][LENS_SUMS];
};

static inline void lens_sum_inner(const struct lens_gather *g, size_t first, uint32_t tap,
                                  uint32_t end, struct lens_sums *sum)
{
    for (; tap < end; tap++) {
        const size_t at = (size_t)((ptrdiff_t)first + g->taps[tap].at);
        for (size_t v = 0; v < LENS_VECTORS; v++)
            for (int s = 0; s < LENS_SUMS; s++)
                sum->v[v][s] +=
                    simd_load_vector(g->plane[LENS_CELL_WEIGHT + s] + at + v * SIMD_PER_VECTOR);
    }
}

/* Adds a tap at the aperture's edge. Where it covers no lens area, not even zeros are added. */
static inline void lens_sum_outer(const struct lens_gather *g, size_t first, uint32_t tap,
                                  uint32_t end, struct lens_sums *sum)
{
    const float *reach = g->plane[LENS_CELL_REACH], *plane[LENS_SUMS]; /* to be kept at hand */
    for (int s = 0; s < LENS_SUMS; s++) plane[s] = g->plane[LENS_CELL_WEIGHT + s];
    for (; tap < end; tap++) {
        const size_t at = (size_t)((ptrdiff_t)first + g->taps[tap].at);
        simd_vector in[LENS_VECTORS], any = {0};
        for (size_t v = 0; v < LENS_VECTORS; v++) {
            in[v] = lens_covered(simd_load_vector(reach + at + v * SIMD_PER_VECTOR),
                                 g->taps[tap].distance);
            any = (simd_vector)((simd_mask)any | (simd_mask)in[v]);
        }
        if (!lens_is_any(any)) continue;
        for (size_t v = 0; v < LENS_VECTORS; v++)
            for (int s = 0; s < LENS_SUMS; s++)
                sum->v[v][s] += in[v] * simd_load_vector(plane[s] + at + v * SIMD_PER_VECTOR);
    }
}

static void kernel_gather(const struct lens_gather *g, size_t first, uint32_t count, float *out,
                          size_t stride)
{
    for (uint32_t i = 0; i < count; i += LENS_VECTORS * SIMD_PER_VECTOR) {
        uint32_t tap = 0;
        for (int group = 0; group < LENS_GROUPS; group++) {
            struct lens_sums sum = {{{{0}}}};
            lens_sum_inner(g, first + i, tap, g->inner[group], &sum);
            lens_sum_outer(g, first + i, g->inner[group], g->end[group], &sum);
            tap = g->end[group];
            for (size_t v = 0; v < LENS_VECTORS; v++)
                for (int s = 0; s < LENS_SUMS; s++)
                    *(simd_stored *)(out + (size_t)(group * LENS_SUMS + s) * stride + i +
                                     v * SIMD_PER_VECTOR) = sum.v[v][s];
        }
    }
}

/* Returns the lower of two whole numbers. */
static inline simd_mask lens_lower(simd_mask a, simd_mask b)
{
    const simd_mask is_lower = a < b;
    return (is_lower & a) | (~is_lower & b);
}

/* Returns the bits of lens_layer_of. */
static inline simd_mask lens_layer_bits(simd_vector slope)
{
    const simd_mask none = {0}, one = none + 1, sizes = (simd_mask)slope & INT32_MAX;
    const simd_mask k = (sizes >> 22) - (127 << 1); /* below 0: in focus */
    const simd_mask band = lens_lower(k, none + LENS_BANDS);
    const simd_mask front = none + (LENS_FOCUS - 1) - band, behind = band + (LENS_FOCUS + 1);
    const simd_mask is_front = slope > 0.0f, out = k >= 0;
    const simd_mask layer = (is_front & front) | (~is_front & behind);
    return one << ((out & layer) | (~out & (none + LENS_FOCUS)));
}

static uint32_t kernel_layers(const float *slope, uint32_t count)
{
    uint32_t bits = 0, i = 0;
    simd_mask all = {0};
    for (; i + SIMD_PER_VECTOR <= count; i += SIMD_PER_VECTOR)
        all |= lens_layer_bits(simd_load_vector(slope + i));
    for (uint32_t k = 0; k < SIMD_PER_VECTOR; k++) bits |= (uint32_t)all[k];
    for (; i < count; i++) bits |= 1u << lens_layer_of(slope[i]);
    return bits;
}

static void kernel_lines(const struct lens_aperture *a, uint32_t l, uint32_t i, uint32_t count,
                         const float *across, float *height, float *left, float *length)
{
    if (a->bands == 0)
        lens_disc_lines(l, i, count, across, height, left, length);
    else
        lens_band_lines(a, l, i, count, across, height, left, length);
}
