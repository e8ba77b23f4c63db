#pragma once
/* lens_kernels, vectors of pixels side by side: whatever instruction set the including file is
 * compiled for, each pixel sees the same operations in the same order. */
#include <string.h>

#include "proto/lens_pattern.h"
#include "server/reconstruct/indirect_vector.h"
#include "server/reconstruct/lens_kernels.h"
#include "server/reconstruct/lens_layer.h"

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

static inline void lens_sum_outer(const struct lens_gather *g, size_t first, uint32_t tap,
                                  uint32_t end, struct lens_sums *sum)
{
    for (; tap < end; tap++) {
        const size_t at = (size_t)((ptrdiff_t)first + g->taps[tap].at);
        for (size_t v = 0; v < LENS_VECTORS; v++) {
            const size_t to = at + v * LANES_PER_VECTOR;
            const lanes_vector in = lens_covered(lanes_load_vector(g->plane[LENS_CELL_REACH] + to),
                                                 g->taps[tap].distance);
            for (int s = 0; s < LENS_SUMS; s++)
                sum->v[v][s] += in * lanes_load_vector(g->plane[LENS_CELL_WEIGHT + s] + to);
        }
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

static void kernel_lines(uint32_t l, uint32_t i, uint32_t count, const float *across, float *height,
                         float *left, float *length)
{
    lens_disc_lines(l, i, count, across, height, left, length);
}

static inline lanes_mask lens_select_whole(lanes_mask mask, lanes_mask a, lanes_mask b)
{
    return (mask & a) | (~mask & b);
}

/* The greatest whole numbers not above x, which are small. */
static inline lanes_mask lens_floor(lanes_vector x)
{
    const lanes_mask whole = __builtin_convertvector(x, lanes_mask);
    return whole + (__builtin_convertvector(whole, lanes_vector) > x);
}

/* Whose samples a vector of them are: columns of their pixels. */
static inline lanes_mask lens_columns(int32_t first)
{
    lanes_mask out;
    for (int32_t i = 0; i < LANES_PER_VECTOR; i++) out[i] = first + i;
    return out;
}

/* A mask of the last `count` digits. */
static inline lanes_mask lens_digits(int32_t count)
{
    const int32_t digits = (1 << count) - 1;
    return (lanes_mask){0} + digits;
}

/* Samples i on: those of the layer lie where their slope takes them. */
static inline lanes_mask lens_place_vector(const struct lens_place *p, uint32_t i)
{
    const lanes_vector s = lanes_load_vector(p->slope + i);
    const lanes_mask near = s >= p->low, own = near & (s < p->high);
    const lanes_mask taken = p->beyond ? ~near : own;
    const lanes_mask moves = (s >= p->close) & (s < p->high) & (p->fixed ? 0 : -1);
    const lanes_vector slope = lanes_select(moves, s, lanes_load_vector(p->pass + i));
    const lanes_vector u = lanes_load_vector(p->left + i) +
                           lanes_load_vector(p->chord + i) *
                               ((p->stratum + lanes_load_vector(p->along + i)) * p->strata_inverse);
    const lanes_mask pixel = lens_columns(p->x + (int32_t)i),
                     phase = pixel & lens_digits(p->coarse);
    const lanes_vector x =
        p->cells * (__builtin_convertvector(phase, lanes_vector) + 0.5f + slope * u);
    const lanes_vector y =
        p->cells * (p->row_phase + 0.5f + slope * lanes_load_vector(p->height + i));
    const lanes_mask column = (pixel >> p->coarse << p->fine) + lens_floor(x) - p->column;
    const lanes_mask row = lens_floor(y) - p->row;
    const lanes_mask inside = (column >= 0) & (column < p->columns) & (row >= 0) & (row < p->rows);
    const lanes_mask none = inside | -1;
    const lanes_mask at =
        row * p->stride + (column & lens_digits(p->fine)) * p->phase_step + (column >> p->fine);
    return lens_select_whole(taken & inside, at, none);
}

/* Fewer samples than a vector has. */
static inline void lens_place_few(const struct lens_place *p, uint32_t count, int32_t *cell)
{
    float memory[6][LANES_PER_VECTOR] = {{0}};
    lanes_mask out;
    struct lens_place few = *p;
    const float **const arrays[6] = {&few.slope, &few.along,  &few.left,
                                     &few.chord, &few.height, &few.pass};
    for (int k = 0; k < 6; k++) {
        memcpy(memory[k], *arrays[k], count * sizeof(float));
        *arrays[k] = memory[k];
    }
    out = lens_place_vector(&few, 0);
    memcpy(cell, &out, count * sizeof *cell);
}

/* The last vector may begin among the samples of the one before. */
static void kernel_place(const struct lens_place *place, uint32_t count, int32_t *cell)
{
    const struct lens_place p = *place;
    const uint32_t most = LANES_PER_VECTOR;
    if (count < most) {
        lens_place_few(&p, count, cell);
        return;
    }
    for (uint32_t i = 0; i < count; i += most) {
        const uint32_t at = i + most > count ? count - most : i;
        *(lanes_stored_mask *)(cell + at) = lens_place_vector(&p, at);
    }
}
