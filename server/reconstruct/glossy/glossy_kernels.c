/* All instruction sets have the same operations in the same order, but SSE4.2 rounds what the
 * others fuse (fused.h). */
#include "server/reconstruct/glossy/glossy_kernels.h"

#include "server/reconstruct/glossy/glossy_lanes.h"

const struct glossy_kernels KERNELS(glossy_kernels) = {
    .spread = {[GLOSSY_ELLIPTIC] = kernel_spread_elliptic,
               [GLOSSY_ROUND] = kernel_spread_round,
               [GLOSSY_MIXTURE] = kernel_spread_mixture},
};
