#pragma once
/* The inner loops of lens_residual.h, compiled once for each instruction set. They run over planes,
 * or rows of them. */
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

/* The planes of a picture to which the difference to its average is added. */
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
    /* Computes means of n numbers `step` apart, in their order, and adds the sums of their squares
     * to *squares. */
    void (*average)(const float *in, size_t step, uint32_t n, size_t count, float *out,
                    float *squares);

    void (*add)(float *out, const float *in, size_t count); /* out += in */
    void (*divide)(float *numbers, float by, size_t count); /* numbers /= by */

    /* Computes out = a - b, and adds its square to *squares. */
    void (*difference)(const float *a, const float *b, size_t count, float *out, float *squares);

    /* Computes the sum of the squares of three numbers. */
    void (*square)(const float *const in[3], size_t count, float *out);

    /* Turns squares into the squared error that noise leaves in a mean over `pixels`, from the
     * differences around or from the lens's variance. */
    void (*noise)(const float *found, const float *noise, const float *pixels, size_t count,
                  float *squares);

    /* Adds as much of the mean difference as `found` is above `factor` times the noise. */
    void (*give)(const struct lens_residual_planes *planes, float factor, size_t count);

    /* Adds as much of the pixels' own difference as is above their noise, which is the lens's and
     * `factor` times that of n samples. It leaves slopes from `slope` on as they are. */
    void (*give_own)(const struct lens_residual_planes *planes, float factor, float slope, float n,
                     size_t count);
};

/* The kernels of each instruction set (kernels.h). All give the same bits. */
extern const struct lens_residual_kernels lens_residual_kernels_sse42, lens_residual_kernels_avx2,
    lens_residual_kernels_avx512;
