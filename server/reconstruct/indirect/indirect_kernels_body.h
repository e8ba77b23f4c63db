/* The table of kernels, compiled once for each instruction set: define INDIRECT_KERNELS as its name
 * and include this. The same operations in the same order everywhere, but that SSE4.2 rounds what
 * others fuse (fused.h). */
#include "server/reconstruct/indirect/indirect_lanes.h"

const struct indirect_kernels INDIRECT_KERNELS = {
    .mean = kernel_mean,
    .line = kernel_line,
    .nearness = kernel_nearness,
};
