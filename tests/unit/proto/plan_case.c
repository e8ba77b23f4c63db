#include "tests/unit/proto/plan_case.h"

#include <string.h>

void plan_case(struct plan *plan)
{
    const struct plan_light point = {.type = LIGHT_POINT,
                                     .position = {1, 2, 3},
                                     .color = {1, 2, 3},
                                     .range = 10,
                                     .power = 0.5f,
                                     .strata_per_axis = 1};
    const struct plan_light spot = {.type = LIGHT_SPOT,
                                    .position = {1, 2, 3},
                                    .direction = {0, -1, 0},
                                    .color = {4, 5, 6},
                                    .cos_inner = 0.9f,
                                    .cos_outer = 0.7f,
                                    .power = 1,
                                    .strata_per_axis = 1};
    const struct plan_light directional = {.type = LIGHT_DIRECTIONAL,
                                           .direction = {0.6f, -0.8f, 0},
                                           .color = {7, 8, 9},
                                           .power = 2,
                                           .strata_per_axis = 1};
    const struct plan_light rectangle = {.type = LIGHT_RECTANGLE,
                                         .profile = PROFILE_GAUSSIAN,
                                         .position = {0, 4, 0},
                                         .direction = {0, -1, 0},
                                         .half_u = {0.5f, 0, 0},
                                         .half_v = {0, 0, 0.5f},
                                         .color = {20, 20, 20},
                                         .power = 3,
                                         .strata_per_axis = 3};
    *plan = (struct plan){
        .width_px = 720,
        .height_px = 480,
        .tile_px = 32,
        .pattern = {.seed = 0x0123456789abcdefu, .frame = 7},
        .camera = {.type = CAMERA_PERSPECTIVE,
                   .eye = {0, 1, 5},
                   .right = {1, 0, 0},
                   .up = {0, 1, 0},
                   .forward = {0, 0, -1},
                   .half_width = 0.75f,
                   .half_height = 0.5f,
                   .aperture_radius = 0.05f,
                   .focus_distance = 4,
                   .blade_count = 6,
                   .blade_rotation_rad = 0.3f},
        .light_count = 4,
        .lights = {point, spot, directional, rectangle},
        .environment = {.kind = ENVIRONMENT_MAP,
                        .radiance = {0.5f, 0.75f, 1},
                        .rotation_rad = -1.5f,
                        .power = 6},
        .paths = {.spp = 100, .pixel_filter = PIXEL_FILTER_TENT, .emitter_power = 0.25f},
        .occlusion_distance = 2,
        .mu = 0.5f,
        .planes = PLAN_CASE_PLANES,
        .light_planes = PLAN_CASE_LIGHT_PLANES,
        .sub_samples = 3,
        .bounces = 1,
        .indirect_strata_per_axis = 3,
        .lens_strata_per_axis = 2,
        .lens_relight = LENS_RELIGHT_DIFFUSE,
        .radiance_scale = 0.25f,
        .length_unit = 8,
        .capabilities = CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_PATHS,
    };
    for (int i = 0; i < DIGEST_BYTES; i++) {
        plan->scene.bytes[i] = (uint8_t)(i * 7 + 1);
        plan->environment.map.bytes[i] = (uint8_t)(i * 5 + 3);
    }
}
