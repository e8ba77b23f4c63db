/* What lights a planned scene: lamps, environment and emitters, their shares of the power, and what
 * it is told of darkness. */
#include <math.h>
#include <string.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

EACH_TEST(stage_set_up, stage_tear_down);

TEST(warns_of_darkness)
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

TEST(a_studio_light_stands_where_nothing_else_lights)
{
    struct stage *s = *state;
    s->has_studio = true;
    s->studio = (struct environment_header){.mean = {0.5f, 0.5f, 0.5f}, .maximum = {6, 6, 6}};
    assert_int_equal(make(s), 0); /* the lamp does */
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_NONE);
    s->scene.count[SCENE_LIGHTS] = 0;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_MAP);
    assert_int_equal(s->plan.environment.map.bytes[0], 9);
    assert_true(s->plan.environment.radiance[1] == 1 && s->report.studio_light);
    assert_true(has_warning(s, "a neutral studio light does") && !has_warning(s, "black"));
    json_t *report = plan_report_json(&s->plan, &s->report);
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(report, "environment"), "type")),
        "studio");
    json_decref(report);
    s->job.default_light = false;
    assert_int_equal(make(s), 0);
    assert_true(s->plan.environment.kind == ENVIRONMENT_NONE && has_warning(s, "black"));
    s->job.default_light = true;
    s->material.emission[1] = 2;
    assert_int_equal(make(s), 0); /* a lamp */
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_NONE);
    s->material.emission[1] = 1;
    assert_int_equal(make(s), 0); /* a display */
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_MAP);
    s->material = (struct scene_material){.flags = MATERIAL_UNLIT, .specular = 1};
    assert_int_equal(make(s), 0); /* nothing needs light */
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_NONE);
}

TEST(an_estimate_stands_beside_lamps_but_for_an_environment)
{
    struct stage *s = *state;
    s->has_estimate = true;
    s->estimate = (struct environment_header){.mean = {0.5f, 0.5f, 0.5f}, .maximum = {6, 6, 6}};
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.environment.kind, ENVIRONMENT_MAP);
    assert_int_equal(s->plan.environment.map.bytes[0], 10);
    assert_true(s->plan.light_count > 0 && s->report.estimated_light && !s->report.studio_light);
    json_t *report = plan_report_json(&s->plan, &s->report);
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(report, "environment"), "type")),
        "estimate");
    json_decref(report);
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    assert_int_equal(make(s), 0);
    assert_true(s->plan.environment.kind == ENVIRONMENT_CONSTANT && !s->report.estimated_light);
}

TEST(a_job_that_wants_darkness_gets_no_studio_light)
{
    struct stage *s = *state;
    s->job.scene_lights = false;
    assert_false(plan_may_want_studio(&s->job, &s->scene));
    s->job.scene_lights = true;
    assert_true(plan_may_want_studio(&s->job, &s->scene));
    s->job.light_count = 1; /* black, say */
    assert_false(plan_may_want_studio(&s->job, &s->scene));
    s->job.light_count = 0;
    s->job.environment.kind = ENVIRONMENT_CONSTANT;
    assert_false(plan_may_want_studio(&s->job, &s->scene));
}

/* Without lights the path tracer is in the dark just the same; anything that shines changes it. */
TEST(paths_know_darkness)
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

static bool near_share(float power, double expected)
{
    return fabsf(power - (float)expected) < 1e-5f * (float)expected;
}

TEST(powers_have_one_unit)
{
    struct stage *s = *state;
    const double lamp = M_PI * 0.25 * (0.2126 * 10 + 0.7152 * 8 + 0.0722 * 6);
    const double sky = M_PI * 3 * M_PI * 2; /* radius^2 3, luminance 2 */
    double glow = M_PI * 2 * 0.5;           /* area 2, luminance 0.5 */
    for (int c = 0; c < 3; c++) s->material.emission[c] = 0.5f;
    s->job.method = FILTER_NONE;
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {2, 2, 2}};
    assert_int_equal(make(s), 0);
    double sum = lamp + sky + glow;
    assert_true(near_share(s->plan.lights[0].power, lamp / sum));
    assert_true(near_share(s->plan.environment.power, sky / sum));
    assert_true(near_share(s->plan.paths.emitter_power, glow / sum));
    assert_int_equal(s->plan.capabilities, CAPABILITY_PATHS | CAPABILITY_ENVIRONMENT);
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

TEST(maps_are_planned_from_their_header)
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
    assert_int_equal(s->plan.capabilities, CAPABILITY_PATHS);
}

TEST(drops_what_cannot_matter)
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

TEST(refuses_too_many_lights)
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
TEST(skipped_lights_leave_room)
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

/* Blender writes watts as candela: the exposure that shows such a scene is told, and then is right.
 */
TEST(lights_of_other_units_are_told)
{
    struct stage *s = *state;
    s->job.scene_lights = false;
    s->job.light_count = 1;
    s->job.lights[0] = (struct plan_light){.type = LIGHT_POINT,
                                           .power = 1,
                                           .position = {0, 4, 0},
                                           .color = {16000, 9, 9}}; /* 8.3 stops four away */
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "some 8 stops brighter than white: image.exposure -8 shows"));
    s->job.exposure = -8;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "brighter than white"));
}
