#pragma once
/* The curves of view_transform.h for pixels side by side, compiled once for each instruction set.
 * They work in double precision and without fused operations, so that all sets give the same bits.
 */
#include "proto/runtime/kernels.h"
#include "server/image/view_transform.h"

struct view_kernels {
    /* Replaces light by what is shown of it. */
    void (*show)(enum view_curve curve, double scale, struct view_pixels *pixels);
};

extern const struct view_kernels view_kernels_sse42, view_kernels_avx2, view_kernels_avx512;
