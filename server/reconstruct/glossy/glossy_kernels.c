/* All instruction sets have the same operations in the same order, but SSE4.2 rounds what the
 * others fuse (fused.h). */
#include "server/reconstruct/glossy/glossy_kernels.h"

#include "server/reconstruct/glossy/glossy_lanes.h"

const struct glossy_kernels KERNELS(glossy_kernels) = {
    .spread = kernel_spread,
};
