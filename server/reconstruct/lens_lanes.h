#pragma once
/* lens_kernels, vectors of pixels side by side: whatever instruction set the including file is
 * compiled for, each pixel sees the same operations in the same order. */
#include <math.h>

#include "server/reconstruct/indirect_vector.h"
#include "server/reconstruct/lens_kernels.h"

static inline lanes_vector lens_covered(lanes_vector reach, float distance)
{
    const lanes_vector zero = {0}, one = 1.0f - zero, in = reach - distance;
    const lanes_vector least = lanes_select(in > zero, in, zero);
    return lanes_select(least < one, least, one);
}

/* Taps tap .. end - 1 of a vector of pixels. */
static inline void lens_gather_group(const struct lens_gather *g, size_t first, uint32_t tap,
                                     uint32_t end, lanes_vector sum[LENS_SUMS])
{
    for (int s = 0; s < LENS_SUMS; s++) sum[s] = (lanes_vector){0};
    for (; tap < end; tap++) {
        const size_t at = (size_t)((ptrdiff_t)first + g->taps[tap].at);
        const lanes_vector in =
            lens_covered(lanes_load_vector(g->plane[LENS_CELL_REACH] + at), g->taps[tap].distance);
        for (int s = 0; s < LENS_SUMS; s++)
            sum[s] += in * lanes_load_vector(g->plane[LENS_CELL_WEIGHT + s] + at);
    }
}

static void kernel_gather(const struct lens_gather *g, size_t first, uint32_t count, float *out,
                          size_t stride)
{
    for (uint32_t i = 0; i < count; i += LANES_PER_VECTOR) {
        uint32_t tap = 0;
        for (int group = 0; group < LENS_GROUPS; group++) {
            lanes_vector sum[LENS_SUMS];
            lens_gather_group(g, first + i, tap, g->end[group], sum);
            tap = g->end[group];
            for (int s = 0; s < LENS_SUMS; s++)
                *(lanes_stored *)(out + (size_t)(group * LENS_SUMS + s) * stride + i) = sum[s];
        }
    }
}

static void kernel_place(const struct lens_place *p, uint32_t count, int32_t *restrict cell)
{
    for (uint32_t i = 0; i < count; i++) {
        const float s = p->slope[i];
        const int32_t own = (s >= p->low) & (s < p->high);
        const int32_t taken = p->beyond ? s < p->low : own;
        const float slope = own && !p->fixed ? s : p->pass[i];
        const float u = p->left[i] + p->chord[i] * ((p->stratum + p->along[i]) * p->strata_inverse);
        const int32_t pixel = p->x + (int32_t)i, phase = pixel & ((1 << p->coarse) - 1);
        const float x = p->cells * ((float)phase + 0.5f + slope * u);
        const float y = p->cells * (p->row_phase + 0.5f + slope * p->height[i]);
        const int32_t column = (pixel >> p->coarse << p->fine) + (int32_t)floorf(x) - p->column;
        const int32_t row = (int32_t)floorf(y) - p->row;
        const int32_t inside = (column >= 0) & (column < p->columns) & (row >= 0) & (row < p->rows);
        const int32_t at =
            row * p->stride + (column & p->fine) * p->half_step + (column >> p->fine);
        cell[i] = taken & inside ? at : -1;
    }
}
