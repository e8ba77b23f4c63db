#pragma once
/* lens_kernels, vectors of pixels side by side: whatever instruction set the including file is
 * compiled for, each pixel sees the same operations in the same order. */
#include <string.h>

#include "proto/lens_pattern.h"
#include "server/reconstruct/indirect_vector.h"
#include "server/reconstruct/lens_cell_lanes.h"
#include "server/reconstruct/lens_kernels.h"
#include "server/reconstruct/lens_layer.h"
#include "server/reconstruct/lens_line_lanes.h"

static inline lanes_vector lens_covered(lanes_vector reach, float distance)
{
    const lanes_vector zero = {0}, one = 1.0f - zero, in = reach - distance;
    const lanes_vector least = lanes_select(in > zero, in, zero);
    return lanes_select(least < one, least, one);
}

/* Vectors that are summed at once: as many as registers hold sums of. */
#ifdef __AVX512F__
#define LENS_VECTORS 1
#elif defined __AVX__
#define LENS_VECTORS 2
#else
#define LENS_VECTORS 1
#endif

struct lens_sums {
    lanes_vector v[LENS_VECTORS][LENS_SUMS];
};

static inline void lens_sum_inner(const struct lens_gather *g, size_t first, uint32_t tap,
                                  uint32_t end, struct lens_sums *sum)
{
    for (; tap < end; tap++) {
        const size_t at = (size_t)((ptrdiff_t)first + g->taps[tap].at);
        for (size_t v = 0; v < LENS_VECTORS; v++)
            for (int s = 0; s < LENS_SUMS; s++)
                sum->v[v][s] +=
                    lanes_load_vector(g->plane[LENS_CELL_WEIGHT + s] + at + v * LANES_PER_VECTOR);
    }
}

/* Where nothing is covered nothing is added, not even zeros. */
static inline void lens_sum_outer(const struct lens_gather *g, size_t first, uint32_t tap,
                                  uint32_t end, struct lens_sums *sum)
{
    for (; tap < end; tap++) {
        const size_t at = (size_t)((ptrdiff_t)first + g->taps[tap].at);
        lanes_vector in[LENS_VECTORS];
        lanes_mask any = {0};
        for (size_t v = 0; v < LENS_VECTORS; v++) {
            in[v] = lens_covered(
                lanes_load_vector(g->plane[LENS_CELL_REACH] + at + v * LANES_PER_VECTOR),
                g->taps[tap].distance);
            any |= in[v] > 0.0f;
        }
        if (!lens_signs(any)) continue;
        for (size_t v = 0; v < LENS_VECTORS; v++)
            for (int s = 0; s < LENS_SUMS; s++)
                sum->v[v][s] += in[v] * lanes_load_vector(g->plane[LENS_CELL_WEIGHT + s] + at +
                                                          v * LANES_PER_VECTOR);
    }
}

static void kernel_gather(const struct lens_gather *g, size_t first, uint32_t count, float *out,
                          size_t stride)
{
    for (uint32_t i = 0; i < count; i += LENS_VECTORS * LANES_PER_VECTOR) {
        uint32_t tap = 0;
        for (int group = 0; group < LENS_GROUPS; group++) {
            struct lens_sums sum = {{{{0}}}};
            lens_sum_inner(g, first + i, tap, g->inner[group], &sum);
            lens_sum_outer(g, first + i, g->inner[group], g->end[group], &sum);
            tap = g->end[group];
            for (size_t v = 0; v < LENS_VECTORS; v++)
                for (int s = 0; s < LENS_SUMS; s++)
                    *(lanes_stored *)(out + (size_t)(group * LENS_SUMS + s) * stride + i +
                                      v * LANES_PER_VECTOR) = sum.v[v][s];
        }
    }
}

static uint32_t kernel_layers(const float *slope, uint32_t count)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < count; i++) bits |= 1u << lens_layer_of(slope[i]);
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
