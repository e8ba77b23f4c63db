/* What a plan decides, over scenes made by hand: effects, planes, lights, camera, reasons. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "proto/message.h"
#include "proto/plan_check.h"
#include "proto/samples.h"
#include "server/job/fingerprint.h"
#include "server/job/import_folder.h"
#include "server/job/imports.h"
#include "tests/unit/server/plan_stage.h"

static void plans_a_lit_scene(void **state)
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

static void keeps_the_vertical_view(void **state)
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

static void finds_cameras(void **state)
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

static void looks_at_a_target(void **state)
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

static void warns_of_scales_that_floats_cannot_hold(void **state)
{
    struct stage *s = *state;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "radius"));
    for (int i = 0; i < 3; i++) s->info.bounds_min[i] = -1e-7f, s->info.bounds_max[i] = 1e-7f;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "so small"));
    for (int i = 0; i < 3; i++) s->info.bounds_min[i] = -1e13f, s->info.bounds_max[i] = 1e13f;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "so large"));
}

static void warns_of_darkness(void **state)
{
    struct stage *s = *state;
    s->scene.count[SCENE_LIGHTS] = 0;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_count, 0);
    assert_int_equal(s->plan.bounces, 0);
    assert_int_equal(s->plan.capabilities, 0);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
    assert_non_null(strstr(s->report.warnings[s->report.warning_count - 1], "add \"lights\""));
    assert_string_equal(why(s, "effect indirect"), "nothing lights the scene");
    /* What glows is seen even where the lights that it stands for are switched off. */
    s->material.emission[1] = 2;
    s->mesh.flags = MESH_IS_LIGHT;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.bounces, 0);
    assert_true(s->plan.planes & PLANE_BIT(EMISSION));
    assert_int_equal(s->report.warning_count, 0);
    /* An unlit surface lights by bounces. */
    s->material = (struct scene_material){.flags = MATERIAL_UNLIT, .specular = 1};
    s->mesh.flags = 0;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
    assert_int_equal(s->plan.bounces, 1);
    assert_true(s->plan.planes & PLANE_BIT(EMISSION));
    assert_int_equal(s->report.warning_count, 0);
}

/* Without lights the path tracer is in the dark just the same; anything that shines changes it. */
static void paths_know_darkness(void **state)
{
    struct stage *s = *state;
    s->job.method = FILTER_NONE;
    s->scene.count[SCENE_LIGHTS] = 0;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "an \"environment\""));
    assert_int_equal(s->plan.bounces, 0);
    assert_string_equal(why(s, "effect direct"), "nothing lights the scene");
    assert_string_equal(why(s, "effect indirect"), "nothing lights the scene");
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {0, 0, 1}};
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "black"));
    assert_int_equal(s->plan.bounces, 1);
    s->job.environment.kind = ENVIRONMENT_NONE;
    s->material.emission[0] = 1;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "black"));
    assert_int_equal(s->plan.bounces, 1);
    s->mesh.flags = MESH_IS_LIGHT;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "black"));
    assert_int_equal(s->plan.bounces, 0);
}

#define BIT(plane) PLANE_BIT(plane)

static void none_is_paths(void **state)
{
    struct stage *s = *state;
    s->job.method = FILTER_NONE;
    s->job.spp = 10;
    s->job.indirect_bounces = 64;
    assert_int_equal(make(s), 0);
    assert_int_equal(plan_check(&s->plan, &s->fault), 0);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_int_equal(s->report.method, FILTER_NONE);
    assert_int_equal(s->plan.paths.spp, 16);
    assert_int_equal(s->plan.bounces, 64);
    assert_int_equal(s->plan.indirect_strata_per_axis, 0);
    assert_int_equal(s->plan.sub_samples, 0);
    assert_int_equal(s->plan.planes, BIT(PATH_RADIANCE) | BIT(PATH_COVERAGE));
    assert_int_equal(s->plan.light_planes, 0);
    assert_int_equal(s->plan.lights[0].strata_per_axis, 1);
    assert_int_equal(s->plan.capabilities, CAPABILITY_PATHS);
    assert_string_equal(why(s, "light fields"), "filter.method is none: every sample is a path");
    assert_string_equal(why(s, "plane path_spread"), "no layer of this plan reads it");
    assert_string_equal(why(s, "plane depth"), "no layer of this plan reads it");
    assert_string_equal(why(s, "effect lens"), "the camera is a pinhole");
    assert_null(why(s, "paths"));
    assert_int_equal(s->report.effects, EFFECT_PRIMARY | EFFECT_ANTIALIAS | EFFECT_DIRECT |
                                            EFFECT_SHADOWS | EFFECT_INDIRECT);
    s->job.indirect_bounces = 0;
    s->job.light_spp = s->job.indirect_spp = 4;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.bounces, 0);
    assert_string_equal(why(s, "effect indirect"), "effects.indirect_bounces is 0");
    assert_non_null(why(s, "sampling.light_spp"));
    assert_non_null(why(s, "sampling.indirect_spp"));
}

static void paths_bring_what_layers_read(void **state)
{
    static const struct {
        uint32_t layer, planes;
    } cases[] = {
        {LAYER_BEAUTY, BIT(PATH_COVERAGE)},
        {LAYER_DIRECT, BIT(PATH_DIRECT)},
        {LAYER_INDIRECT, BIT(PATH_INDIRECT)},
        {LAYER_EMISSION, BIT(PATH_EMISSION)},
        {LAYER_ALBEDO, BIT(PATH_ALBEDO)},
        {LAYER_ERROR, BIT(PATH_SPREAD) | BIT(PATH_SPLIT)},
        {LAYER_OCCLUSION, BIT(PATH_OCCLUSION)},
        {LAYER_DIFFUSE_DIRECT, BIT(PATH_DIFFUSE_DIRECT)},
        {LAYER_DIFFUSE_INDIRECT, BIT(PATH_DIFFUSE_INDIRECT)},
        {LAYER_SAMPLES, 0},
        {LAYER_DEPTH, BIT(DEPTH)},
        {LAYER_NORMAL, BIT(DEPTH) | BIT(NORMAL)},
        {LAYER_ID, BIT(ID)},
        {LAYER_VISIBILITY, BIT(DEPTH)},
        {LAYER_SLOPE_MIN, BIT(DEPTH)},
        {LAYER_SLOPE_MAX, BIT(DEPTH)},
        {LAYER_FILTER_WIDTH, 0},
    };
    struct stage *s = *state;
    s->job.method = FILTER_NONE;
    s->job.occlusion_distance = 2;
    uint32_t seen = 0;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        s->job.layers = cases[i].layer;
        seen |= cases[i].layer;
        if (make(s) != 0) fail_msg("%s: %s", layer_name(cases[i].layer), s->fault.detail);
        assert_int_equal(s->plan.planes, cases[i].planes | BIT(PATH_RADIANCE));
        assert_true(s->plan.occlusion_distance ==
                    (cases[i].layer == LAYER_OCCLUSION ? 2.0f : 0.0f));
    }
    assert_int_equal(seen, LAYERS_AVAILABLE);
    s->job.layers = LAYERS_AVAILABLE;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.planes, PLANES_PATH | BIT(DEPTH) | BIT(NORMAL) | BIT(ID));
}

static void paths_keep_strata_for_their_layers(void **state)
{
    struct stage *s = *state;
    s->job.method = FILTER_NONE;
    s->job.spp = 1024;
    s->job.light_spp = 16;
    s->job.layers = LAYER_VISIBILITY | LAYER_SLOPE_MAX;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_planes, 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES);
    assert_int_equal(s->plan.lights[0].strata_per_axis, 4);
    assert_int_equal(s->plan.capabilities, CAPABILITY_PATHS | CAPABILITY_VISIBILITY);
    assert_null(why(s, "sampling.light_spp"));
    s->job.light_spp = 0;
    assert_int_equal(make(s), ERR_LIMIT);
    assert_string_equal(s->fault.pointer, "/sampling/spp");
}

/* One thing after the other that light fields cannot do. */
static void auto_tells_why_it_is_paths(void **state)
{
    struct stage *s = *state;
    const struct scene_material lambert = s->material;
    const struct job job = s->job;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
    assert_string_equal(why(s, "paths"), "light fields cover the scene and the layers");
    assert_null(why(s, "light fields"));
#define PATHS(sentence)                                                                            \
    do {                                                                                           \
        assert_int_equal(make(s), 0);                                                              \
        assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);                                  \
        assert_true(s->plan.paths.spp == 9 && s->plan.planes & BIT(PATH_RADIANCE));                \
        assert_string_equal(why(s, "light fields"), sentence);                                     \
        s->material = lambert;                                                                     \
        s->job = job;                                                                              \
    } while (0)
    s->material.alpha_mode = ALPHA_BLEND;
    PATHS("material 0 \"main\" lets light through by its alpha");
    s->job.pixel_filter = PIXEL_FILTER_TENT;
    PATHS("image.pixel_filter is not box");
    s->job.aperture_radius = 0.1f;
    s->job.focus_distance = 4;
    s->job.layers |= LAYER_ALBEDO;
    PATHS("with a lens only paths give the layer albedo");
    s->job.layers |= LAYER_ERROR;
    s->job.indirect_bounces = 0;
    PATHS("only along paths has light from areas a known error");
    /* Paths bring all light that there is. */
    s->job.indirect_bounces = 0;
    s->material.metallic = 0.5f;
    PATHS("material 0 \"main\" is not Lambert");
#undef PATHS
    /* None of these is in its way. */
    s->material.alpha_mode = ALPHA_MASK;
    s->mesh.flags = MESH_IS_LIGHT;
    s->material.emission[2] = 1;
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {0, 0, 0}};
    s->job.occlusion_distance = 1;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
    assert_true(s->plan.paths.spp == 0 && s->plan.occlusion_distance == 0);
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_NONE);
    assert_string_equal(why(s, "effect environment"), "its radiance is black");
    assert_true(has_warning(s, "nothing shows it"));
    assert_string_equal(why(s, "effect occlusion"), "the layer occlusion is not asked for");
}

static void names_of_materials_stay_ascii(void **state)
{
    struct stage *s = *state;
    memcpy(s->names + 1, "m\xc3\xa4 \xff", 6);
    s->material.specular = 1;
    assert_int_equal(make(s), 0);
    assert_string_equal(why(s, "light fields of lights"),
                        "material 0 \"m\\xc3\\xa4 \\xff\" is not Lambert");
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    json_decref(json);
}

static bool near_share(float power, double expected)
{
    return fabsf(power - (float)expected) < 1e-5f * (float)expected;
}

static void powers_have_one_unit(void **state)
{
    struct stage *s = *state;
    const double lamp = M_PI * 0.25 * (0.2126 * 10 + 0.7152 * 8 + 0.0722 * 6);
    const double sky = M_PI * 3 * M_PI * 2; /* radius^2 3, luminance 2 */
    double glow = M_PI * 2 * 0.5;           /* area 2, luminance 0.5 */
    for (int c = 0; c < 3; c++) s->material.emission[c] = 0.5f;
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {2, 2, 2}};
    assert_int_equal(make(s), 0);
    double sum = lamp + sky + glow;
    assert_true(near_share(s->plan.lights[0].power, lamp / sum));
    assert_true(near_share(s->plan.environment.power, sky / sum));
    assert_true(near_share(s->plan.paths.emitter_power, glow / sum));
    assert_int_equal(s->plan.capabilities,
                     CAPABILITY_PATHS | CAPABILITY_INDIRECT | CAPABILITY_ENVIRONMENT);
    /* Both sides, and two more placements: moved and twice as large; stretched along z alone, which
     * a triangle in the plane of x and y does not feel. */
    s->material.flags = MATERIAL_DOUBLE_SIDED;
    s->scene.count[SCENE_INSTANCES] = 3;
    memcpy(s->instances[1].to_world, (float[]){0, 2, 0, 9, -2, 0, 0, 0, 0, 0, 2, 0}, 48);
    memcpy(s->instances[2].to_world, (float[]){1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 5, 0}, 48);
    assert_int_equal(make(s), 0);
    glow *= 2 * (1 + 4 + 1);
    sum = lamp + sky + glow;
    assert_int_equal(s->report.emitters.instances, 3);
    assert_false(has_warning(s, "scene.lights is false"));
    s->job.scene_lights = false;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "scene.lights is false"));
    s->job.scene_lights = true;
    assert_int_equal(make(s), 0);
    assert_true(near_share(s->plan.paths.emitter_power, glow / sum));
    /* A faint one still gets its least share. */
    for (int c = 0; c < 3; c++) s->job.environment.radiance[c] = 1e-9f;
    assert_int_equal(make(s), 0);
    assert_true(near_share(s->plan.environment.power, 1e-3));
    s->mesh.flags = MESH_IS_LIGHT;
    assert_int_equal(make(s), 0);
    assert_true(s->plan.paths.emitter_power == 0);
    assert_non_null(why(s, "effect emitters"));
}

static void maps_are_planned_from_their_header(void **state)
{
    struct stage *s = *state;
    const double luminance = 0.2126 * 1 + 0.7152 * 2 + 0.0722 * 3;
    s->scene.count[SCENE_LIGHTS] = 0;
    for (int c = 0; c < 3; c++) s->material.emission[c] = 1;
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_MAP, .intensity = 4, .rotation_deg = 270};
    assert_int_equal(make(s), 0);
    const struct plan_environment *e = &s->plan.environment;
    assert_int_equal(e->kind, ENVIRONMENT_MAP);
    assert_int_equal(e->map.bytes[0], 8);
    assert_true(e->radiance[0] == 4 && e->radiance[1] == 4 && e->radiance[2] == 4);
    assert_true(fabsf(e->rotation_rad + 1.5707964f) < 1e-6f);
    double sky = M_PI * 3 * M_PI * luminance * 4;
    assert_true(near_share(e->power, sky / (sky + M_PI * 2)));
    assert_true(s->report.effects & EFFECT_ENVIRONMENT);
    s->job.environment.intensity = 4e9f;
    assert_int_equal(make(s), ERR_RANGE);
    assert_string_equal(s->fault.pointer, "/environment/intensity");
    s->job.environment.intensity = 0;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_NONE);
    assert_true(digest_is_zero(&s->plan.environment.map));
    assert_int_equal(s->plan.capabilities, CAPABILITY_PATHS | CAPABILITY_INDIRECT);
}

static void lenses_need_perspective(void **state)
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

static void warns_of_an_error_without_samples(void **state)
{
    struct stage *s = *state;
    s->job.layers = LAYER_ERROR;
    s->job.spp = 1;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "one path a pixel"));
    s->job.spp = 4;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "one path a pixel"));
}

static void drops_what_cannot_matter(void **state)
{
    struct stage *s = *state;
    s->job.light_count = 5;
    for (int i = 0; i < 5; i++)
        s->job.lights[i] = (struct plan_light){.type = LIGHT_POINT,
                                               .position = {0, 0, 10},
                                               .color = {1, 1, 1},
                                               .cos_inner = 1,
                                               .direction = {0, 0, -1}};
    memset(s->job.lights[0].color, 0, sizeof s->job.lights[0].color);
    s->job.lights[1].range = 8.9f;
    s->job.lights[2].range = 9.1f;
    s->job.lights[3].type = LIGHT_RECTANGLE; /* above the box, shining up */
    memcpy(s->job.lights[3].position, (float[3]){0, 2, 0}, 12);
    memcpy(s->job.lights[3].half_u, (float[3]){0, 0, 1}, 12);
    memcpy(s->job.lights[3].half_v, (float[3]){1, 0, 0}, 12);
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_count, 3);
    assert_string_equal(why(s, "light /lights/0"), "its colour is black");
    assert_string_equal(why(s, "light /lights/1"), "its range ends before the scene begins");
    assert_string_equal(why(s, "light /lights/3"), "it faces away from the whole scene");
    assert_true(s->report.lights[0].of_scene);
    assert_int_equal(s->report.lights[1].index, 2);
    assert_int_equal(s->report.lights[2].index, 4);
    s->job.scene_lights = false;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_count, 2);
    assert_non_null(why(s, "scene lights"));
}

static void refuses_too_many_lights(void **state)
{
    struct stage *s = *state;
    for (int i = 0; i <= LIMIT_LIGHTS; i++) set_lamp(&s->lights[i]);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS;
    assert_int_equal(make(s), 0);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS + 1;
    assert_int_equal(make(s), ERR_LIMIT);
    assert_string_equal(s->fault.pointer, "/lights");
}

/* However many lights are left out, it is told who makes the picture. */
static void skipped_lights_leave_room(void **state)
{
    struct stage *s = *state;
    for (int i = 0; i <= LIMIT_LIGHTS; i++) {
        set_lamp(&s->lights[i]);
        memset(s->lights[i].color, 0, sizeof s->lights[i].color);
    }
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS + 1;
    s->job.light_count = LIMIT_LIGHTS;
    for (int i = 0; i < LIMIT_LIGHTS; i++) s->job.lights[i] = (struct plan_light){.power = 1};
    s->job.method = FILTER_NONE;
    s->job.light_spp = s->job.indirect_spp = 4;
    assert_int_equal(make(s), 0);
    assert_non_null(why(s, "light scene light 0"));
    assert_non_null(why(s, "light fields"));
    assert_non_null(why(s, "effect indirect"));
    assert_true(s->report.skip_count < PLAN_SKIPS);
}

static void layers_bring_their_planes(void **state)
{
    struct stage *s = *state;
    s->job.layers = LAYER_BEAUTY | LAYER_VISIBILITY | LAYER_SLOPE_MAX;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.light_planes, 6); /* those that the filter reads */
    assert_true(s->plan.capabilities & CAPABILITY_VISIBILITY);
    s->job.light_spp = 17 * 17;
    assert_int_equal(make(s), ERR_LIMIT);
    assert_string_equal(s->fault.pointer, "/sampling/light_spp");
    s->job.layers = LAYER_BEAUTY;
    assert_int_equal(make(s), 0);
}

#define STRATA_PLANES (1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES)

static void expect_filter(struct stage *s, uint32_t filter, uint32_t light_planes,
                          const char *words)
{
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
    assert_int_equal(s->plan.shadow_filter, filter);
    assert_int_equal(s->plan.light_planes, light_planes);
    if (!strstr(s->report.filter_why, words)) fail_msg("\"%s\"", s->report.filter_why);
    assert_true((filter == SHADOW_FILTER_NONE) == (why(s, "filter") != NULL));
    assert_true((filter == SHADOW_FILTER_SHEARED) == (s->report.method == FILTER_SHEARED));
    assert_true((filter == SHADOW_FILTER_NONE) == (s->report.method == FILTER_NONE));
}

static void auto_filters_what_has_area(void **state)
{
    struct stage *s = *state;
    for (uint32_t l = 1; l <= LIMIT_PLANE_STRATA_PER_AXIS; l++) {
        s->job.spp = l * l;
        expect_filter(s, SHADOW_FILTER_SHEARED, STRATA_PLANES, l == 1 ? "1 sample a" : "samples a");
    }
    s->job.light_spp = 17 * 17;
    expect_filter(s, SHADOW_FILTER_NONE, 1u << LIGHT_PLANE_IRRADIANCE, "289 samples a light");
    assert_int_equal(s->report.warning_count, 0);
    s->job.light_spp = 4;
    expect_filter(s, SHADOW_FILTER_SHEARED, STRATA_PLANES, "4 samples a light");
}

static void filters_are_taken_as_asked(void **state)
{
    struct stage *s = *state;
    s->job.mu = 2.5f;
    s->job.method = FILTER_AXIS_ALIGNED;
    expect_filter(s, SHADOW_FILTER_AXIS_ALIGNED, STRATA_PLANES, "asks for it");
    assert_true(s->plan.mu == 2.5f);
    s->job.method = FILTER_SHEARED;
    expect_filter(s, SHADOW_FILTER_SHEARED, STRATA_PLANES, "asks for it");
    s->job.spp = 400;
    expect_filter(s, SHADOW_FILTER_NONE, 1u << LIGHT_PLANE_IRRADIANCE, "400 samples a light");
    assert_true(
        has_warning(s, "filter.method is sheared, but shadows are not filtered: 400 samples"));
}

/* Without bits and slopes: an average of any number of samples. */
static void averages_light_fields(void **state)
{
    struct stage *s = *state;
    const uint32_t irradiance = 1u << LIGHT_PLANE_IRRADIANCE;
    s->job.method = FILTER_AVERAGE;
    s->job.layers = LAYER_BEAUTY | LAYER_DIFFUSE_DIRECT | LAYER_DIFFUSE_INDIRECT;
    expect_filter(s, SHADOW_FILTER_NONE, irradiance, "filter.method is average");
    s->job.light_spp = 4096;
    expect_filter(s, SHADOW_FILTER_NONE, irradiance, "filter.method is average");
    assert_int_equal(s->report.warning_count, 0);
}

/* Irradiance travels for lights without area, strata for those with it, nothing for none. */
static void filters_leave_sharp_lights(void **state)
{
    struct stage *s = *state;
    const uint32_t irradiance = 1u << LIGHT_PLANE_IRRADIANCE;
    s->job.light_count = 1;
    s->job.lights[0] = (struct plan_light){
        .type = LIGHT_POINT, .position = {0, 0.5f, 0}, .color = {1, 1, 1}, .power = 1};
    expect_filter(s, SHADOW_FILTER_SHEARED, STRATA_PLANES | irradiance, "samples a light");
    assert_int_equal(plan_light_planes(&s->plan, 0), STRATA_PLANES);
    assert_int_equal(plan_light_planes(&s->plan, 1), irradiance);
    assert_null(why(s, "plane irradiance"));
    s->job.scene_lights = false;
    s->job.indirect = INDIRECT_AVERAGE;
    for (int i = 0; i < 3; i++) {
        static const enum filter_method methods[] = {FILTER_AUTO, FILTER_SHEARED,
                                                     FILTER_AXIS_ALIGNED};
        s->job.method = methods[i];
        s->job.layers = LAYER_BEAUTY | LAYER_VISIBILITY | LAYER_FILTER_WIDTH;
        expect_filter(s, SHADOW_FILTER_NONE, irradiance, "no light has area");
        assert_true(has_warning(s, "the layer filter_width is 0"));
        assert_true(has_warning(s, "but shadows are not filtered") == (methods[i] != FILTER_AUTO));
        assert_false(s->plan.capabilities & CAPABILITY_VISIBILITY);
    }
    /* A rectangle that cannot matter is none. */
    s->job.lights[0] = (struct plan_light){.type = LIGHT_RECTANGLE,
                                           .position = {0, 5, 0},
                                           .half_u = {1, 0, 0},
                                           .half_v = {0, 0, -1},
                                           .color = {1, 1, 1},
                                           .power = 1};
    assert_int_equal(make(s), 0);
    assert_non_null(why(s, "light /lights/0"));
    assert_int_equal(s->plan.light_planes, 0);
    assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_NONE);
}

static void auto_minds_the_cost(void **state)
{
    struct stage *s = *state;
    for (int i = 0; i < LIMIT_LIGHTS; i++) set_lamp(&s->lights[i]);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS;
    s->job.spp = 1;
    expect_filter(s, SHADOW_FILTER_AXIS_ALIGNED, STRATA_PLANES, "would cost about");
    s->job.spp = 4;
    expect_filter(s, SHADOW_FILTER_SHEARED, STRATA_PLANES, "needs the fewest");
}

/* Filters that the light field cannot have are no fault: the job is made of paths, and says so. */
static void filters_need_light_fields(void **state)
{
    struct stage *s = *state;
    s->material.metallic = 1;
    s->job.indirect_bounces = 0;
    s->job.layers = LAYER_BEAUTY | LAYER_FILTER_WIDTH;
    static const enum filter_method methods[] = {FILTER_AUTO, FILTER_SHEARED, FILTER_AXIS_ALIGNED};
    for (int i = 0; i < 3; i++) {
        s->job.method = methods[i];
        assert_int_equal(make(s), 0);
        assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
        assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_NONE);
        assert_int_equal(s->report.method, FILTER_NONE);
        assert_non_null(strstr(s->report.filter_why, "is not Lambert"));
        assert_non_null(strstr(why(s, "filter"), "is not Lambert"));
        assert_true(has_warning(s, "but shadows are not filtered: ") ==
                    (methods[i] != FILTER_AUTO));
        assert_true(has_warning(s, "the layer filter_width is 0"));
    }
}

static void shrinks_tiles_to_a_message(void **state)
{
    struct stage *s = *state;
    for (int i = 0; i < LIMIT_LIGHTS; i++) set_lamp(&s->lights[i]);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS;
    s->job.layers = LAYER_VISIBILITY;
    s->job.light_spp = 256;
    s->job.tile_px = 256;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.tile_px, 128);
    assert_non_null(strstr(s->report.warnings[s->report.warning_count - 1], "256"));
}

static void reports_as_json(void **state)
{
    struct stage *s = *state;
    s->scene.count[SCENE_WARNINGS] = 21;
    assert_int_equal(make(s), 0);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_int_equal(json_array_size(json_object_get(json, "warnings")), 2);
    assert_int_equal(json_array_size(json_object_get(json, "lights")), 1);
    json_t *skip = json_array_get(json_object_get(json, "skipped"), 0);
    assert_true(json_is_string(json_object_get(skip, "what")));
    assert_true(json_is_string(json_object_get(skip, "why")));
    assert_string_equal(json_string_value(json_object_get(json, "integrator")), "light_field");
    assert_true(json_is_null(json_object_get(json, "environment")));
    assert_true(json_is_null(json_object_get(json, "emitters")));
    json_decref(json);
}

static void has_word(const json_t *list, const char *word)
{
    size_t i;
    json_t *item;
    json_array_foreach (list, i, item)
        if (!strcmp(json_string_value(item), word)) return;
    fail_msg("%s is missing", word);
}

static void reports_paths_as_json(void **state)
{
    struct stage *s = *state;
    s->material.emission[0] = 1;
    s->job.spp = 100;
    s->job.layers = LAYERS_AVAILABLE;
    s->job.occlusion_distance = 1;
    s->job.aperture_radius = s->job.focus_distance = 1;
    s->job.environment = (struct job_environment){.kind = ENVIRONMENT_MAP, .intensity = 1};
    assert_int_equal(make(s), 0);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_string_equal(json_string_value(json_object_get(json, "integrator")), "paths");
    static const char *const effects[] = {"primary",  "antialias",  "direct", "shadows",
                                          "indirect", "emission",   "lens",   "occlusion",
                                          "emitters", "environment"};
    for (size_t i = 0; i < sizeof effects / sizeof effects[0]; i++)
        has_word(json_object_get(json, "effects"), effects[i]);
    static const char *const planes[] = {"depth",       "path_radiance", "path_diffuse_indirect",
                                         "path_albedo", "path_coverage", "path_occlusion"};
    for (size_t i = 0; i < sizeof planes / sizeof planes[0]; i++)
        has_word(json_object_get(json, "planes"), planes[i]);
    const json_t *environment = json_object_get(json, "environment");
    assert_string_equal(json_string_value(json_object_get(environment, "type")), "map");
    assert_int_equal(json_string_length(json_object_get(environment, "map")), 64);
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(json, "emitters"), "instances")), 1);
    const json_t *samples = json_object_get(json, "samples");
    assert_int_equal(json_integer_value(json_object_get(samples, "paths")), 100);
    assert_int_equal(json_integer_value(json_object_get(samples, "passes")), 4);
    assert_true(
        json_real_value(json_object_get(json_object_get(json, "camera"), "focus_distance")) == 1);
    json_decref(json);
}

static void fingerprints_leave_out_how(void **state)
{
    struct stage *s = *state;
    char a[FINGERPRINT_BYTES], b[FINGERPRINT_BYTES];
    assert_int_equal(fingerprint_of(&s->job, a), 0);
    s->job.priority = 7;
    s->job.tile_px = 64;
    assert_int_equal(fingerprint_of(&s->job, b), 0);
    assert_string_equal(a, b);
    const struct job job = s->job;
#define OTHER(change)                                                                              \
    do {                                                                                           \
        s->job = job;                                                                              \
        change;                                                                                    \
        assert_int_equal(fingerprint_of(&s->job, b), 0);                                           \
        assert_string_not_equal(a, b);                                                             \
    } while (0)
    OTHER(s->job.seed++);
    OTHER(s->job.environment.kind = ENVIRONMENT_CONSTANT);
    OTHER((s->job.environment.kind = ENVIRONMENT_MAP, s->job.environment.asset.bytes[9] = 1));
    OTHER(s->job.aperture_radius = 1);
    OTHER(s->job.occlusion_distance = 1);
    OTHER(s->job.indirect_bounces = 2);
    OTHER(s->job.layers |= LAYER_ERROR);
#undef OTHER
    s->job = job;
}

static void sources_depend_on_names_not_order(void **state)
{
    struct stage *s = *state;
    struct job_file files[2] = {{(char *)"a.bin", {{1}}}, {(char *)"b.png", {{2}}}};
    struct job_file swapped[2] = {files[1], files[0]};
    struct job_file renamed[2] = {files[0], {(char *)"c.png", {{2}}}};
    struct digest first, second, third;
    struct job job = s->job;
    job.file_count = 2;
    job.files = files;
    assert_int_equal(imports_source(&job, &first), 0);
    job.files = swapped;
    assert_int_equal(imports_source(&job, &second), 0);
    job.files = renamed;
    assert_int_equal(imports_source(&job, &third), 0);
    assert_true(digest_equal(&first, &second));
    assert_false(digest_equal(&first, &third));
}

static void sniffs_kinds(void **state)
{
    (void)state;
    assert_string_equal(import_folder_sniff("glTF\2\0\0\0", 8), ".glb");
    assert_string_equal(import_folder_sniff("\xef\xbb\xbf {\"asset\"", 12), ".gltf");
    assert_string_equal(import_folder_sniff("# Blender\nv 0 0 0\n", 18), ".obj");
    assert_string_equal(import_folder_sniff("#?RADIANCE\n", 11), ".hdr");
    assert_string_equal(import_folder_sniff("\x76\x2f\x31\x01\2\0", 6), ".exr");
    assert_null(import_folder_sniff("# bin\0ary", 9));
    assert_null(import_folder_sniff("\x89PNG\r\n", 6));
    assert_null(import_folder_sniff("  ", 2));
    assert_null(import_folder_sniff("", 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
        TEST(plans_a_lit_scene),
        TEST(keeps_the_vertical_view),
        TEST(finds_cameras),
        TEST(looks_at_a_target),
        TEST(warns_of_darkness),
        TEST(warns_of_scales_that_floats_cannot_hold),
        TEST(paths_know_darkness),
        TEST(none_is_paths),
        TEST(paths_bring_what_layers_read),
        TEST(paths_keep_strata_for_their_layers),
        TEST(auto_tells_why_it_is_paths),
        TEST(names_of_materials_stay_ascii),
        TEST(powers_have_one_unit),
        TEST(maps_are_planned_from_their_header),
        TEST(lenses_need_perspective),
        TEST(warns_of_an_error_without_samples),
        TEST(drops_what_cannot_matter),
        TEST(refuses_too_many_lights),
        TEST(skipped_lights_leave_room),
        TEST(layers_bring_their_planes),
        TEST(auto_filters_what_has_area),
        TEST(filters_are_taken_as_asked),
        TEST(averages_light_fields),
        TEST(filters_leave_sharp_lights),
        TEST(auto_minds_the_cost),
        TEST(filters_need_light_fields),
        TEST(shrinks_tiles_to_a_message),
        TEST(reports_as_json),
        TEST(reports_paths_as_json),
        TEST(fingerprints_leave_out_how),
        TEST(sources_depend_on_names_not_order),
        TEST(sniffs_kinds),
    };
    return cmocka_run_group_tests_name("plan", tests, NULL, NULL);
}
