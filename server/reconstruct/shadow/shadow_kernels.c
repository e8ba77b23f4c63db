/* All instruction sets have the same operations in the same order, but SSE4.2 rounds what the
 * others fuse (fused.h). */
#include "server/reconstruct/shadow/shadow_kernels.h"

#include "server/reconstruct/shadow/blur_lanes.h"
#include "server/reconstruct/shadow/edge_lanes.h"
#include "server/reconstruct/shadow/estimate_lanes.h"
#include "server/reconstruct/shadow/project_row_lanes.h"
#include "server/reconstruct/shadow/receiver_lanes.h"
#include "server/reconstruct/shadow/slope_lanes.h"
#include "server/reconstruct/shadow/unoccluded_lanes.h"
#include "server/reconstruct/shadow/walk_lanes.h"
#include "server/reconstruct/shadow/wedge_lanes.h"

const struct shadow_kernels KERNELS(shadow_kernels) = {
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
