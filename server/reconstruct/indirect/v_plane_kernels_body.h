/* The table of kernels, compiled once for each instruction set: define V_PLANE_KERNELS as its name
 * and include this. The same operations in the same order everywhere, but that SSE4.2 rounds what
 * others fuse (fused.h). */
#include "server/reconstruct/indirect/v_plane_slope_lanes.h"
#include "server/reconstruct/indirect/v_plane_walk_lanes.h"

const struct v_plane_kernels V_PLANE_KERNELS = {
    .strata = kernel_strata,
    .slopes = kernel_slopes,
    .average = kernel_average,
    .records = kernel_records,
    .columns = kernel_columns,
    .rows = kernel_rows,
};
