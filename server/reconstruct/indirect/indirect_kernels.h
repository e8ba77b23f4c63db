#pragma once
/* The inner loops of the filters of indirect light, once for each instruction set, and the arrays
 * they read.
 *
 * All arrays have the field's layout: rows of `stride` numbers with room around what is filtered,
 * so that sixteen receiving pixels side by side can look INDIRECT_REACH_MAX_PX columns to both
 * sides. Pixels that show nothing, or where nothing was measured, have a zero normal: no neighbour
 * takes them.
 *
 * Sums run over differences from the receiving pixel's own value: a constant channel comes out
 * constant to the last bit. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

#define INDIRECT_LANES   16
#define INDIRECT_TAPS    128 /* neighbours on a line, at most: INDIRECT_REACH_MAX_PX a side */
#define INDIRECT_NEAR_PX 2   /* around a pixel, that its nearness is the mean of */
#define INDIRECT_COS     0.984807753f /* 10 degrees */
#define INDIRECT_CUT     3.125f       /* exponents beyond count nothing: |d| > 2.5 beta */

struct indirect_field {
    int32_t stride;         /* a multiple of INDIRECT_LANES */
    const float *point[3];  /* from the eye */
    const float *normal[3]; /* unit, or 0: nobody takes it */
    const int32_t *object;  /* 0: no surface */
    const float *falloff;   /* 1 / (2 beta^2); 0: keeps its own value */
    const float *off;       /* neighbours may be that far off the tangent plane */
};

/* Receiving pixels first .. first + count - 1, a multiple of INDIRECT_LANES, and how many pixels
 * they look to both sides, `step` apart. */
struct indirect_run {
    size_t first;
    uint32_t count;
    ptrdiff_t step;        /* 1 along x, the stride along y */
    int32_t before, after; /* at most INDIRECT_REACH_MAX_PX each */
};

struct indirect_kernels {
    /* Rule A along one line (docs/reconstruction.md, Indirect means and lines): out[c] = the mean
     * of in[c] over the neighbours of one surface, weights exp(-|d|^2 falloff). A walk ends where
     * the same object lies farther than the cut; others that lie there it passes over. */
    void (*mean)(const struct indirect_field *field, const struct indirect_run *run, uint32_t count,
                 const float *const *in, float *const *out);

    /* Rule B: the same neighbours and weights; a straight line through them, read at the pixel.
     * Where they lie to one side or are few, the mean; nowhere below a quarter of it. */
    void (*line)(const struct indirect_field *field, const struct indirect_run *run, uint32_t count,
                 const float *const *in, float *const *out);

    /* The mean of `nearness` (1 / z; 0: does not count) over the 5 x 5 pixels of the same object
     * around; 0 where none counts. Row by row, from the top left; `step` is the stride, before and
     * after (at most INDIRECT_NEAR_PX) the rows that there are. */
    void (*nearness)(const struct indirect_field *field, const struct indirect_run *run,
                     const float *nearness, float *out);
};

/* One for each instruction set (kernels.h). AVX2 and AVX-512 give the same bits. */
extern const struct indirect_kernels indirect_kernels_sse42, indirect_kernels_avx2,
    indirect_kernels_avx512;
