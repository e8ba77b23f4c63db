#include "worker/trace/field/field_kernels.h"

#include "worker/trace/field/lone_lanes.h"

const struct field_kernels KERNELS(field_kernels) = {
    .unpack_normals = kernel_unpack_normals,
    .match_subs = kernel_match_subs,
};
