#pragma once
/* Sums over the pixels around each pixel, separably: along the rows, then along the columns. */
#include <stddef.h>
#include <stdint.h>

#define CONVOLVE_RADIUS_MAX 64

/* Weights of the pixels from -radius to radius: [0] is that of the one farthest left. */
struct convolve_weights {
    int32_t radius;
    double weight[2 * CONVOLVE_RADIUS_MAX + 1];
};

enum convolve_border {
    CONVOLVE_ZERO,     /* nothing lies beyond the border */
    CONVOLVE_REPLICATE /* the border's own values do */
};

/* Sums `in` into `out`. Both arrays have width * height numbers, row by row, and may be the same.
 * ERR_MEMORY. */
int convolve(const float *in, int32_t width, int32_t height, const struct convolve_weights *across,
             const struct convolve_weights *down, enum convolve_border border, float *out);
