/* Which filter a plan takes for shadows, and why; the planes and tiles that go with it. */
#include <string.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

EACH_TEST(stage_set_up, stage_tear_down);

TEST(layers_bring_their_planes)
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

TEST(auto_filters_what_has_area)
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

TEST(filters_are_taken_as_asked)
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
TEST(averages_light_fields)
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
TEST(filters_leave_sharp_lights)
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

TEST(auto_minds_the_cost)
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
TEST(filters_need_light_fields)
{
    struct stage *s = *state;
    s->material.alpha_mode = ALPHA_BLEND;
    s->job.indirect_bounces = 0;
    s->job.layers = LAYER_BEAUTY | LAYER_FILTER_WIDTH;
    static const enum filter_method methods[] = {FILTER_AUTO, FILTER_SHEARED, FILTER_AXIS_ALIGNED};
    for (int i = 0; i < 3; i++) {
        s->job.method = methods[i];
        assert_int_equal(make(s), 0);
        assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
        assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_NONE);
        assert_int_equal(s->report.method, FILTER_NONE);
        assert_non_null(strstr(s->report.filter_why, "lets light through"));
        assert_non_null(strstr(why(s, "filter"), "lets light through"));
        assert_true(has_warning(s, "but shadows are not filtered: ") ==
                    (methods[i] != FILTER_AUTO));
        assert_true(has_warning(s, "the layer filter_width is 0"));
    }
}

TEST(shrinks_tiles_to_a_message)
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
