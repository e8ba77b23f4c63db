/* The table of kernels, compiled once for each instruction set: define GLOSSY_KERNELS as its name
 * and include this. The same operations in the same order everywhere, but that SSE4.2 rounds what
 * others fuse (fused.h). */
#include "server/reconstruct/glossy/glossy_lanes.h"

const struct glossy_kernels GLOSSY_KERNELS = {
    .spread = kernel_spread,
};
