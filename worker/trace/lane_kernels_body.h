/* The table of kernels, compiled once for each instruction set: define LANE_KERNELS as its name and
 * include this. */
#include "worker/trace/lane_kernels.h"
#include "worker/trace/light_lanes.h"
#include "worker/trace/octahedron_lanes.h"
#include "worker/trace/ray_lanes.h"
#include "worker/trace/surface_lanes.h"

const struct lane_kernels LANE_KERNELS = {
    .sanitise = kernel_sanitise,
    .gather_surface = kernel_gather_surface,
    .finish_surface = kernel_finish_surface,
    .pack_normals = kernel_pack_normals,
    .sample_light = kernel_sample_light,
    .light_hidden = kernel_light_hidden,
    .add_stratum = kernel_add_stratum,
    .add_slopes = kernel_add_slopes,
};
