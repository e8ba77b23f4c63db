#include "worker/trace/hit/hit_kernels.h"

#include "worker/trace/hit/camera_lanes.h"
#include "worker/trace/hit/geometry_lanes.h"
#include "worker/trace/hit/hit_lanes.h"
#include "worker/trace/hit/pack_lanes.h"
#include "worker/trace/hit/ray_lanes.h"
#include "worker/trace/hit/surface_lanes.h"
#include "worker/trace/hit/texel_lanes.h"

const struct hit_kernels KERNELS(hit_kernels) = {
    .camera_rays = kernel_camera_rays,
    .place_subs = kernel_place_subs,
    .camera_row = kernel_camera_row,
    .sanitise = kernel_sanitise,
    .resolve_hits = kernel_resolve_hits,
    .place_texels = kernel_place_texels,
    .finish_surface = kernel_finish_surface,
    .store_geometry = kernel_store_geometry,
    .relate_depths = kernel_relate_depths,
    .store_sub = kernel_store_sub,
    .pack_normals = kernel_pack_normals,
    .pack_unorms = kernel_pack_unorms,
};
