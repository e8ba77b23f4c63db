/* The table of kernels, compiled once for each instruction set: define SHADOW_KERNELS as its name
 * and include this. The same operations in the same order everywhere, but that SSE4.2 rounds what
 * others fuse (fused.h). */
#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/blur_lanes.h"
#include "server/reconstruct/shadow/edge_lanes.h"
#include "server/reconstruct/shadow/estimate_lanes.h"
#include "server/reconstruct/shadow/project_row_lanes.h"
#include "server/reconstruct/shadow/receiver_lanes.h"
#include "server/reconstruct/shadow/slope_lanes.h"
#include "server/reconstruct/shadow/unoccluded_lanes.h"
#include "server/reconstruct/shadow/walk_lanes.h"
#include "server/reconstruct/shadow/wedge_lanes.h"

const struct shadow_kernels SHADOW_KERNELS = {
    .unoccluded = kernel_unoccluded,
    .place_receivers = kernel_place_receivers,
    .shear_receivers = kernel_shear_receivers,
    .mark_walks = kernel_mark_walks,
    .project_columns = kernel_project_columns,
    .walk_columns = kernel_walk_columns,
    .project_rows = kernel_project_rows,
    .walk_rows = kernel_walk_rows,
    .blur = kernel_blur,
    .estimate = kernel_estimate,
    .filter_edges = kernel_filter_edges,
    .sum_slopes = kernel_sum_slopes,
};
