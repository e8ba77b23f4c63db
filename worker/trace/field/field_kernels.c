#include "worker/trace/field/field_kernels.h"

#include "worker/trace/field/lone_lanes.h"
#include "worker/trace/field/mixed_lanes.h"

const struct field_kernels KERNELS(field_kernels) = {
    .unpack_normals = kernel_unpack_normals,
    .match_subs = kernel_match_subs,
    .place_cells = kernel_place_cells,
    .compare_cells = kernel_compare_cells,
    .mark_colours = kernel_mark_colours,
    .split_subs = kernel_split_subs,
};
