#pragma once
/* The inner loops of the filters of indirect light, compiled once for each instruction set, and the
 * arrays they read.
 *
 * All arrays have the field's layout: rows of `stride` numbers with margins, so that sixteen
 * adjacent receivers can look INDIRECT_REACH_MAX_PX columns to both sides. Pixels without a
 * surface, or where nothing was measured, have a zero normal, which no receiver accepts.
 *
 * Sums run over differences from the receiver's own value, so that a constant channel stays
 * constant to the last bit. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"
#include "server/reconstruct/simd/lanes.h"

#define INDIRECT_TAPS    128          /* most neighbours on a line: INDIRECT_REACH_MAX_PX a side */
#define INDIRECT_NEAR_PX 2            /* radius of the mean of nearness */
#define INDIRECT_COS     0.984807753f /* 10 degrees */
#define INDIRECT_CUT     3.125f       /* exponents beyond weigh 0: |d| > 2.5 beta */

struct indirect_field {
    int32_t stride;         /* a multiple of SIMD_LANES */
    const float *point[3];  /* from the eye */
    const float *normal[3]; /* unit; 0: no receiver accepts it */
    const int32_t *object;  /* 0: no surface */
    const float *falloff;   /* 1 / (2 beta^2); 0: the pixel keeps its value */
    const float *off;       /* how far off the tangent plane neighbours may be */
};

/* Receivers first .. first + count - 1, a multiple of SIMD_LANES, and how many pixels they look
 * to both sides, `step` apart. */
struct indirect_run {
    size_t first;
    uint32_t count;
    ptrdiff_t step;        /* 1 along x, the stride along y */
    int32_t before, after; /* at most INDIRECT_REACH_MAX_PX each */
};

struct indirect_kernels {
    /* Applies rule A along one line (docs/reconstruction.md, Indirect means and lines): out[c]
     * becomes the mean of in[c] over the neighbours of one surface, with weights exp(-|d|^2
     * falloff). A walk ends where the same object lies farther off than the cut; it skips other
     * objects there. */
    void (*mean)(const struct indirect_field *field, const struct indirect_run *run, uint32_t count,
                 const float *const *in, float *const *out);

    /* Applies rule B: fits a straight line through the same neighbours with the same weights and
     * reads it at the pixel. Where they lie to one side or are few, the mean is taken. The result
     * is at least a quarter of the mean. */
    void (*line)(const struct indirect_field *field, const struct indirect_run *run, uint32_t count,
                 const float *const *in, float *const *out);

    /* Computes the mean of `nearness` (1 / z; 0 is left out) over the 5 x 5 pixels of the same
     * object around, row by row from the top left; 0 where none counts. `step` is the stride;
     * before and after are the rows that there are, at most INDIRECT_NEAR_PX. */
    void (*nearness)(const struct indirect_field *field, const struct indirect_run *run,
                     const float *nearness, float *out);
};

/* The kernels of each instruction set (kernels.h). AVX2 and AVX-512 give the same bits. */
extern const struct indirect_kernels indirect_kernels_sse42, indirect_kernels_avx2,
    indirect_kernels_avx512;
