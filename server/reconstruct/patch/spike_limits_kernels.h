#pragma once
/* Sums over linked pixels of a line, once for each instruction set. All compute the same bits. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/runtime/kernels.h"

/* A line's input. link[i] tells of pixels i and i + step: 1 or 0. */
struct spike_limits_line {
    const float *in, *counts, *link;
    ptrdiff_t step;
    int32_t before, after; /* pixels that sums reach */
};

struct spike_limits_kernels {
    /* Sums `in` and `counts` over the pixels that are linked with each of [first, first + width),
     * in whole vectors. */
    void (*sum_line)(const struct spike_limits_line *l, size_t first, size_t width, float *out,
                     float *out_counts);
};

extern const struct spike_limits_kernels spike_limits_kernels_sse42, spike_limits_kernels_avx2,
    spike_limits_kernels_avx512;
