/* When a plan is made of paths, why, and what they bring. */
#include <string.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

#define BIT(plane) PLANE_BIT(plane)

EACH_TEST(stage_set_up, stage_tear_down);

TEST(none_is_paths)
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
    assert_string_equal(why(s, "plane path_m2"), "no layer of this plan reads it");
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

TEST(paths_bring_what_layers_read)
{
    static const struct {
        uint32_t layer;
        uint64_t planes;
    } cases[] = {
        {LAYER_BEAUTY, BIT(PATH_COVERAGE)},
        {LAYER_DIRECT, BIT(PATH_DIRECT)},
        {LAYER_INDIRECT, BIT(PATH_INDIRECT)},
        {LAYER_EMISSION, BIT(PATH_EMISSION)},
        {LAYER_ALBEDO, BIT(PATH_ALBEDO)},
        {LAYER_ERROR, BIT(PATH_M2) | BIT(PATH_HALF_DIFFERENCE2)},
        {LAYER_OCCLUSION, BIT(PATH_VISIBILITY)},
        {LAYER_DIFFUSE_DIRECT, BIT(PATH_DIFFUSE_DIRECT)},
        {LAYER_DIFFUSE_INDIRECT, BIT(PATH_DIFFUSE_INDIRECT)},
        {LAYER_SAMPLES, 0},
        {LAYER_DEPTH, BIT(DEPTH)},
        {LAYER_NORMAL, BIT(DEPTH) | BIT(NORMAL)},
        {LAYER_ID, BIT(ID)},
        {LAYER_MOTION_BACKWARD, BIT(DEPTH) | BIT(ID)},
        {LAYER_MOTION_FORWARD, BIT(DEPTH) | BIT(ID)},
        {LAYER_VISIBILITY, BIT(DEPTH)},
        {LAYER_SLOPE_MIN, BIT(DEPTH)},
        {LAYER_SLOPE_MAX, BIT(DEPTH)},
        {LAYER_FILTER_WIDTH, 0},
        {LAYER_CRYPTO_OBJECT, PLANES_MATTE_OBJECTS},
        {LAYER_CRYPTO_MATERIAL, PLANES_MATTE_MATERIALS},
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
    const uint32_t traced = LAYERS_AVAILABLE & ~(uint32_t)LAYERS_COMPOSITE;
    assert_int_equal(seen, traced);
    s->job.layers = traced;
    assert_int_equal(make(s), 0);
    assert_int_equal(s->plan.planes,
                     PLANES_PATH | PLANES_MATTE | BIT(DEPTH) | BIT(NORMAL) | BIT(ID));
}

TEST(paths_keep_strata_for_their_layers)
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
TEST(auto_tells_why_it_is_paths)
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
    s->job.method = FILTER_AVERAGE;
    s->job.indirect_bounces = 0;
    PATHS("the error of area lights is known only along paths");
    /* No light is of the list. */
    s->job.scene_lights = false;
    s->job.indirect_bounces = 0;
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    PATHS("there is an environment");
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

TEST(warns_of_an_error_without_samples)
{
    struct stage *s = *state;
    s->job.layers = LAYER_ERROR;
    s->material.metallic = 0.5f;
    s->job.spp = 1;
    assert_int_equal(make(s), 0);
    assert_true(has_warning(s, "one path per pixel"));
    s->job.spp = 4;
    assert_int_equal(make(s), 0);
    assert_false(has_warning(s, "one path per pixel"));
}
