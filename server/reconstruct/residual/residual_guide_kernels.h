#pragma once
/* What the residual filter's weights look at, once for each instruction set. All compute the same
 * bits. */
#include "server/reconstruct/residual/residual_kernels.h"

struct residual_guide_kernels {
    /* Computes a component's guides and variances of rows [y0, y1) and columns [x0, x1).
     * For RESIDUAL_MEAN half[0] becomes the mean. */
    void (*find)(const struct residual_pass *pass, const struct residual_field *field,
                 enum residual_component component, struct rect area);
};

extern const struct residual_guide_kernels residual_guide_kernels_sse42,
    residual_guide_kernels_avx2, residual_guide_kernels_avx512;
