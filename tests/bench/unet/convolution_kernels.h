#pragma once
/* The inner loop of convolutions, compiled once for each instruction set. */
#include <stdint.h>

#include "proto/runtime/kernels.h"

#define CONVOLUTION_LANES 16 /* output channels that are summed side by side */

/* Sixteen channels of a row of pixels. */
struct convolution_row {
    const float *inputs[3]; /* the rows above, at and below, from the pixel left of the first */
    int32_t width, channels;
    const float *weights; /* [row][column][input channel][lane] */
    const float *bias;    /* [lane] */
    float *output;        /* of the first pixel */
    int32_t stride;       /* numbers from one output pixel to the next */
};

struct convolution_kernels {
    /* Computes max(0, bias + sum of weights times inputs). It reads up to TENSOR_SLACK_PX pixels
     * behind the row. */
    void (*row)(const struct convolution_row *row);
};

extern const struct convolution_kernels convolution_kernels_sse42, convolution_kernels_avx2,
    convolution_kernels_avx512;
