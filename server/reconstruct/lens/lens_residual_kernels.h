#pragma once
/* The inner loops of what is left of the plain average's difference (lens_residual.h), once for
 * each instruction set. Numbers of planes or of their rows, side by side. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

/* Planes of a picture that is given the difference to its average. */
struct lens_residual_planes {
    const float *average[3];
    float *picture[3];
    const float *mean[3], *there[3]; /* of the difference and of the picture, over a window */
    const float *found;              /* squared difference that is to be compared with `noise` */
    const float *noise;              /* squared errors */
    const float *own;                /* sums of the samples' squares */
    const float *spread;             /* sizes of slopes */
};

struct lens_residual_kernels {
    /* Means of n numbers `step` apart, in their order, and their squares' sums added to *squares.
     */
    void (*average)(const float *in, size_t step, uint32_t n, size_t count, float *out,
                    float *squares);

    void (*add)(float *out, const float *in, size_t count); /* out += in */
    void (*divide)(float *numbers, float by, size_t count); /* numbers /= by */

    /* out = a - b, and its square added to *squares. */
    void (*difference)(const float *a, const float *b, size_t count, float *out, float *squares);

    /* Squares of three numbers added up. */
    void (*square)(const float *const in[3], size_t count, float *out);

    /* The squared error that noise leaves in a mean over `pixels`, by what the differences around
     * say or by what the lens does: squares become that. */
    void (*noise)(const float *found, const float *noise, const float *pixels, size_t count,
                  float *squares);

    /* Adds as much of the mean difference as `found` is above `factor` times the noise. */
    void (*give)(const struct lens_residual_planes *planes, float factor, size_t count);

    /* Adds as much of the pixels' own difference as is above their noise: the lens's and `factor`
     * times that of n samples. Slopes from `slope` on get nothing. */
    void (*give_own)(const struct lens_residual_planes *planes, float factor, float slope, float n,
                     size_t count);
};

/* One for each instruction set (kernels.h). All give the same bits. */
extern const struct lens_residual_kernels lens_residual_kernels_sse42, lens_residual_kernels_avx2,
    lens_residual_kernels_avx512;
