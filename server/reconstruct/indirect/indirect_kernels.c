/* All instruction sets have the same operations in the same order, but SSE4.2 rounds what the
 * others fuse (fused.h). */
#include "server/reconstruct/indirect/indirect_kernels.h"

#include "server/reconstruct/indirect/indirect_lanes.h"

const struct indirect_kernels KERNELS(indirect_kernels) = {
    .mean = kernel_mean,
    .line = kernel_line,
    .nearness = kernel_nearness,
};
