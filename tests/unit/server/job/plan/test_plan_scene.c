/* What a plan takes from a scene made by hand: its light field as a whole, its camera and lens, its
 * scale. */
#include <math.h>
#include <string.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

EACH_TEST(stage_set_up, stage_tear_down);

TEST(plans_a_lit_scene)
{
    struct stage *s = *state;
    assert_int_equal(make(s), 0);
    assert_int_equal(plan_check(&s->plan, &s->fault), 0);
    assert_int_equal(s->plan.light_count, 1);
    assert_int_equal(s->plan.lights[0].strata_per_axis, 3);
    assert_true(fabsf(s->plan.lights[0].power - 1) < 1e-6f);
    assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_SHEARED);
    assert_true(s->plan.mu == 1.0f);
    assert_int_equal(s->plan.light_planes, 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES);
    assert_int_equal(s->plan.bounces, 1);
    assert_int_equal(s->plan.indirect_strata_per_axis, 3);
    assert_int_equal(s->plan.sub_samples, 3);
    assert_true(s->plan.planes & PLANE_BIT(INDIRECT_MEAN));
    assert_false(s->plan.planes & PLANE_BIT(INDIRECT_HALVES));
    assert_false(s->plan.planes & PLANE_BIT(EMISSION));
    assert_int_equal(s->plan.pattern.frame, 3);
    assert_int_equal(s->plan.capabilities,
                     CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY);
    assert_null(why(s, "filter"));
    assert_non_null(why(s, "plane emission"));
    assert_non_null(why(s, "plane irradiance"));
    int exponent;
    assert_true(frexpf(s->plan.radiance_scale, &exponent) == 0.5f);
    assert_true(10 * s->plan.radiance_scale <= 256 && 10 * s->plan.radiance_scale > 100);
    assert_true(s->plan.length_unit == 2.0f); /* radius sqrt 3 */
}

/* However small a light is and however bright for that: what it sends out says how far half floats
 * must reach, or all else would be lost below them. */
TEST(scales_by_what_lights_bring)
{
    struct stage *s = *state;
    struct scene_light *light = &s->lights[0];
    for (int i = 0; i < 3; i++) {
        light->half_u[i] *= 1e-4f, light->half_v[i] *= 1e-4f;
        light->color[i] *= 1e8f;
    }
    assert_int_equal(make(s), 0);
    const float scale = s->plan.radiance_scale;
    for (int i = 0; i < 3; i++) {
        light->half_u[i] *= 0x1p-4f, light->half_v[i] *= 0x1p-4f;
        light->color[i] *= 0x1p8f;
    }
    assert_int_equal(make(s), 0);
    assert_true(s->plan.radiance_scale == scale);
    /* beside it, a thousandth of the radius away, nothing is cut off */
    const double beside = sqrt(3) / 1000,
                 brings = 1e9 * 4 * 2.5e-5 * 2.5e-5 / (3.1416 * beside * beside);
    assert_true((double)scale * brings <= 256 && (double)scale * brings > 100);
}

TEST(keeps_the_vertical_view)
{
    struct stage *s = *state;
    assert_int_equal(make(s), 0);
    assert_true(fabsf(s->plan.camera.half_height - tanf(0.5f)) < 1e-6f);
    assert_true(fabsf(s->plan.camera.half_width - 2 * tanf(0.5f)) < 1e-6f);
    s->cameras[0].type = CAMERA_ORTHOGRAPHIC;
    s->cameras[0].half_width = s->cameras[0].half_height = 3;
    assert_int_equal(make(s), 0);
    assert_true(s->plan.camera.half_width == 6 && s->plan.camera.half_height == 3);
}

TEST(looks_as_measured_cameras_do)
{
    struct stage *s = *state;
    float origin[3], direction[3];
    s->cameras[0].half_width = 0.75f;
    s->cameras[0].centre_x = 0.5f;
    s->cameras[0].centre_y = -0.25f;
    assert_int_equal(make(s), 0);
    const struct plan_camera *c = &s->plan.camera;
    assert_true(c->half_width == 0.75f && fabsf(c->half_height - tanf(0.5f)) < 1e-6f);
    plan_camera_ray(&s->plan, 0.75f * (float)s->plan.width_px, 0.625f * (float)s->plan.height_px,
                    origin, direction);
    for (int k = 0; k < 3; k++) assert_true(fabsf(direction[k] - c->forward[k]) < 1e-6f);
}

TEST(finds_cameras)
{
    struct stage *s = *state;
    s->job.camera.kind = JOB_CAMERA_NAME;
    strcpy(s->job.camera.name, "side");
    assert_int_equal(make(s), 0);
    assert_true(fabsf(s->plan.camera.half_height - tanf(0.25f)) < 1e-6f);
    assert_string_equal(s->report.camera_name, "side");
    strcpy(s->job.camera.name, "top");
    assert_int_equal(make(s), ERR_NOT_FOUND);
    assert_string_equal(s->fault.pointer, "/scene/camera");
    assert_non_null(strstr(s->fault.detail, "\"main\", \"side\""));
    s->job.camera.kind = JOB_CAMERA_INDEX;
    s->job.camera.index = 2;
    assert_int_equal(make(s), ERR_NOT_FOUND);
    s->job.camera.index = 1;
    assert_int_equal(make(s), 0);
}

TEST(looks_at_a_target)
{
    struct stage *s = *state;
    s->job.camera = (struct job_camera){.kind = JOB_CAMERA_LOOK_AT,
                                        .eye = {3, 4, 5},
                                        .target = {0, 1, 0},
                                        .up = {0, 2, 0.1f},
                                        .yfov_deg = 90};
    assert_int_equal(make(s), 0);
    const struct plan_camera *c = &s->plan.camera;
    assert_true(fabsf(c->half_height - 1) < 1e-6f);
    /* The middle of the picture goes through the target. */
    float origin[3], direction[3];
    plan_camera_ray(&s->plan, 100, 50, origin, direction);
    float t = (0 - origin[0]) / direction[0];
    assert_true(fabsf(origin[1] + t * direction[1] - 1) < 1e-5f);
    assert_true(fabsf(origin[2] + t * direction[2]) < 1e-5f);
    memcpy(s->job.camera.up, (float[3]){-3, -3, -5}, sizeof s->job.camera.up);
    assert_int_equal(make(s), ERR_RANGE);
    assert_string_equal(s->fault.pointer, "/scene/camera/up");
}

TEST(warns_of_scales_that_floats_cannot_hold)
{
    struct stage *s = *state;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "radius"));
    for (int i = 0; i < 3; i++) s->info.bounds_min[i] = -1e-7f, s->info.bounds_max[i] = 1e-7f;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "would lose"));
    for (int i = 0; i < 3; i++) s->info.bounds_min[i] = -1e13f, s->info.bounds_max[i] = 1e13f;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "rays would miss"));
}

TEST(lenses_need_perspective)
{
    struct stage *s = *state;
    s->job.aperture_radius = 0.25f;
    s->job.focus_distance = 5;
    s->job.blades = 6;
    s->job.blade_rotation_deg = -350;
    assert_int_equal(make(s), 0);
    const struct plan_camera *c = &s->plan.camera;
    assert_true(c->aperture_radius == 0.25f && c->focus_distance == 5 && c->blade_count == 6);
    assert_true(fabsf(c->blade_rotation_rad - 0.17453293f) < 1e-6f);
    assert_int_equal(s->plan.capabilities & (CAPABILITY_PATHS | CAPABILITY_LENS),
                     CAPABILITY_PATHS | CAPABILITY_LENS);
    assert_true(s->report.effects & EFFECT_LENS);
    s->cameras[0].type = CAMERA_ORTHOGRAPHIC;
    s->cameras[0].half_width = s->cameras[0].half_height = 3;
    assert_int_equal(make(s), ERR_RANGE);
    assert_string_equal(s->fault.pointer, "/lens");
    assert_non_null(strstr(s->fault.detail, "orthographic"));
    s->job.aperture_radius = 0;
    assert_int_equal(make(s), 0);
}

TEST(default_cameras_are_framed_as_asked)
{
    struct stage *s = *state;
    float front[3];
    s->cameras[0].is_default = 1;
    assert_int_equal(make(s), 0);
    assert_memory_equal(s->plan.camera.eye, s->cameras[0].eye, sizeof front);
    memcpy(front, s->plan.camera.eye, sizeof front);
    s->job.default_camera = JOB_VIEW_THREE_QUARTER;
    assert_int_equal(make(s), 0); /* 200 x 100 pixels */
    assert_true(s->plan.camera.eye[0] > 1 && s->plan.camera.eye[1] > 1);
    const float wide = s->plan.camera.eye[2];
    s->job.width_px = 50;
    assert_int_equal(make(s), 0);
    assert_true(s->plan.camera.eye[2] > 1.5f * wide); /* a narrow picture needs more distance */
    s->cameras[0].is_default = 0;
    assert_int_equal(make(s), 0);
    assert_memory_equal(s->plan.camera.eye, front, sizeof front);
}
