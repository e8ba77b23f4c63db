/* All instruction sets have the same operations in the same order, but SSE4.2 rounds what the
 * others fuse (fused.h). */
#include "server/reconstruct/indirect/v_plane_kernels.h"

#include "server/reconstruct/indirect/v_plane_slope_lanes.h"
#include "server/reconstruct/indirect/v_plane_walk_lanes.h"

const struct v_plane_kernels KERNELS(v_plane_kernels) = {
    .strata = kernel_strata,
    .slopes = kernel_slopes,
    .average = kernel_average,
    .records = kernel_records,
    .columns = kernel_columns,
    .rows = kernel_rows,
};
