#include "worker/trace/path/path_kernels.h"

#include "worker/trace/light/sky_lanes.h"
#include "worker/trace/path/layer_lanes.h"
#include "worker/trace/path/light_weight_lanes.h"
#include "worker/trace/path/path_lanes.h"

const struct path_kernels KERNELS(path_kernels) = {
    .path_pairs = kernel_path_pairs,
    .path_pairs_of = kernel_path_pairs_of,
    .frame_pairs = kernel_frame_pairs,
    .ray_keys = kernel_ray_keys,
    .lens_rays = kernel_lens_rays,
    .tangents = kernel_tangents,
    .look_back = kernel_look_back,
    .lambert_scatter = kernel_lambert_scatter,
    .weigh_segments = kernel_weigh_segments,
    .lambert_light = kernel_lambert_light,
    .layers_see = kernel_layers_see,
    .layers_light = kernel_layers_light,
    .layers_scatter = kernel_layers_scatter,
    .layers_turn = kernel_layers_turn,
    .layers_diffuse = kernel_layers_diffuse,
    .layers_gloss = kernel_layers_gloss,
    .find_sky = kernel_find_sky,
    .place_sky = kernel_place_sky,
    .weigh_lights = kernel_weigh_lights,
    .weigh_rectangle = kernel_weigh_rectangle,
    .choose_light = kernel_choose_light,
    .weigh_node = kernel_weigh_node,
    .meet_rectangle = kernel_meet_rectangle,
};
