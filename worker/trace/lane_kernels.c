#include "worker/trace/lane_kernels.h"

#include "worker/trace/field/lone_lanes.h"
#include "worker/trace/hit/camera_lanes.h"
#include "worker/trace/hit/geometry_lanes.h"
#include "worker/trace/hit/hit_lanes.h"
#include "worker/trace/hit/pack_lanes.h"
#include "worker/trace/hit/ray_lanes.h"
#include "worker/trace/hit/surface_lanes.h"
#include "worker/trace/hit/texel_lanes.h"
#include "worker/trace/light/light_lanes.h"
#include "worker/trace/light/shadow_lanes.h"
#include "worker/trace/path/layer_lanes.h"
#include "worker/trace/path/path_lanes.h"
#include "worker/trace/path/sky_lanes.h"

const struct lane_kernels KERNELS(lane_kernels) = {
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
    .unpack_normals = kernel_unpack_normals,
    .match_subs = kernel_match_subs,
    .pack_normals = kernel_pack_normals,
    .pack_unorms = kernel_pack_unorms,
    .sample_light = kernel_sample_light,
    .lattice_jitters = kernel_lattice_jitters,
    .place_strata = kernel_place_strata,
    .light_hidden = kernel_light_hidden,
    .sample_strata = kernel_sample_strata,
    .add_strata = kernel_add_strata,
    .store_visibility = kernel_store_visibility,
    .add_slopes = kernel_add_slopes,
    .path_pairs = kernel_path_pairs,
    .frame_pairs = kernel_frame_pairs,
    .ray_keys = kernel_ray_keys,
    .lens_rays = kernel_lens_rays,
    .tangents = kernel_tangents,
    .look_back = kernel_look_back,
    .lambert_scatter = kernel_lambert_scatter,
    .weigh_segments = kernel_weigh_segments,
    .lambert_light = kernel_lambert_light,
    .find_sky = kernel_find_sky,
    .place_sky = kernel_place_sky,
    .layers_see = kernel_layers_see,
    .layers_light = kernel_layers_light,
    .layers_scatter = kernel_layers_scatter,
    .layers_gloss = kernel_layers_gloss,
    .layers_diffuse = kernel_layers_diffuse,
    .meet_rectangle = kernel_meet_rectangle,
};
