/* What a plan decides about indirect light and occlusion: who brings them, their planes, and
 * why. */
#include <string.h>

#include "proto/link/message.h"
#include "tests/unit/server/job/plan/indirect_stage.h"

EACH_TEST(set_up, stage_tear_down);

TEST(light_fields_bounce_often)
{
    struct stage *s = *state;
    static const uint32_t bounces[] = {1, 2, 64};
    for (int i = 0; i < 3; i++) {
        s->job.indirect_bounces = bounces[i];
        must_make(s);
        assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
        assert_int_equal(s->plan.bounces, bounces[i]);
        assert_int_equal(s->plan.planes,
                         PLANES_ALONE | BIT(INDIRECT_MEAN) | BIT(BOUNCE_DISTANCE_MIN));
        assert_int_equal(s->plan.paths.spp, 0);
        assert_int_equal(s->plan.indirect_strata_per_axis, 3);
        assert_true(s->plan.occlusion_distance == 0);
        assert_true(s->plan.capabilities & CAPABILITY_INDIRECT);
        assert_string_equal(why(s, "plane indirect_halves"), "no layer and no target needs errors");
        assert_string_equal(why(s, "plane indirect_strata"), "no filter of this plan reads it");
        assert_string_equal(why(s, "plane open"), "no layer of this plan reads it");
        assert_null(why(s, "filter of indirect light"));
    }
    s->job.indirect_bounces = 0;
    s->job.indirect_spp = 4;
    must_make(s);
    assert_int_equal(s->plan.planes, PLANES_ALONE);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_NONE);
    assert_int_equal(s->plan.indirect_strata_per_axis, 0);
    assert_string_equal(why(s, "plane indirect_mean"), "there is no indirect light");
    assert_string_equal(why(s, "effect indirect"), "effects.indirect_bounces is 0");
    assert_string_equal(why(s, "filter of indirect light"),
                        "there is neither indirect light nor occlusion to filter");
    assert_non_null(why(s, "sampling.indirect_spp"));
    assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_SHEARED);
}

static void expect_beside(struct stage *s, const char *sentence)
{
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_int_equal(s->plan.paths.spp, 9);
    assert_int_equal(s->plan.paths.without_diffuse_indirect, 1);
    assert_int_equal(s->plan.planes, PLANES_SURFACE | BIT(INDIRECT_MEAN) |
                                         BIT(BOUNCE_DISTANCE_MIN) | BIT(PATH_RADIANCE) |
                                         BIT(PATH_COVERAGE));
    assert_int_equal(s->plan.light_planes, 0);
    assert_int_equal(s->plan.sub_samples, LIMIT_SUB_SAMPLES);
    assert_int_equal(s->plan.indirect_strata_per_axis, 3);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_CONSTANT);
    assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_NONE);
    assert_int_equal(s->report.method, FILTER_NONE);
    assert_true((s->plan.capabilities & (CAPABILITY_PATHS | CAPABILITY_INDIRECT)) ==
                (CAPABILITY_PATHS | CAPABILITY_INDIRECT));
    assert_string_equal(why(s, "light fields of lights"), sentence);
    assert_non_null(strstr(s->report.filter_why, sentence));
    assert_null(why(s, "light fields"));
    assert_null(why(s, "paths"));
    assert_null(why(s, "plane depth"));
    assert_string_equal(why(s, "plane path_diffuse_indirect"), "no layer of this plan reads it");
}

/* One thing after the other that light fields cannot do alone. */
TEST(paths_take_what_light_fields_cannot)
{
    struct stage *s = *state;
    const struct scene_material lambert = s->material;
    const struct job job = s->job;
#define BESIDE(sentence)                                                                           \
    do {                                                                                           \
        expect_beside(s, sentence);                                                                \
        s->material = lambert;                                                                     \
        s->job = job;                                                                              \
    } while (0)
    s->material.metallic = 0.5f;
    BESIDE("material 0 \"main\" is not Lambert");
    s->material.specular = 1;
    s->job.indirect_bounces = 5;
    BESIDE("material 0 \"main\" is not Lambert");
    s->material.transmission = 0.1f;
    BESIDE("material 0 \"main\" is not Lambert");
    s->material.model = MODEL_PHONG;
    BESIDE("material 0 \"main\" is not Lambert");
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    BESIDE("there is an environment");
    s->material.emission[2] = 1;
    BESIDE("some meshes that emit light are not rectangles");
#undef BESIDE
}

/* Nobody asks to filter so many, and paths show them pass by pass. */
TEST(many_samples_are_paths_alone)
{
    struct stage *s = *state;
    s->material.specular = 1;
    s->job.spp = 256;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    s->job.spp = 257;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_string_equal(why(s, "light fields"),
                        "289 samples a pixel are above 256: paths alone show little noise");
    assert_string_equal(s->report.indirect_filter_why, why(s, "light fields"));
    s->job.indirect_spp = 64;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    s->job.indirect_spp = 1024;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    /* Who asks has them, and so do light fields alone. */
    s->job.indirect = INDIRECT_AVERAGE;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    s->job.indirect = INDIRECT_AUTO;
    s->job.method = FILTER_AVERAGE;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    s->job.method = FILTER_AUTO;
    s->material.specular = 0;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
}

TEST(shadows_beside_paths_are_not_filtered)
{
    struct stage *s = *state;
    s->material.specular = 1;
    s->job.method = FILTER_SHEARED;
    s->job.layers = LAYER_BEAUTY | LAYER_FILTER_WIDTH;
    must_make(s);
    assert_true(has_warning(s, "filter.method is sheared, but shadows are not filtered: direct "
                               "light comes along paths"));
    assert_false(has_warning(s, "filter_width"));
    s->job.method = FILTER_AVERAGE;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_NONE);
    assert_true(has_warning(s, "the layer filter_width is 0 everywhere"));
    assert_string_equal(why(s, "plane bounce_distance_min"), "no filter of this plan reads it");
}

TEST(layers_beside_paths_come_from_either)
{
    static const struct {
        uint32_t layer;
        uint64_t planes;
    } cases[] = {
        {LAYER_DIRECT, BIT(PATH_DIRECT)},
        {LAYER_INDIRECT, BIT(PATH_INDIRECT)},
        {LAYER_EMISSION, BIT(PATH_EMISSION)},
        {LAYER_ALBEDO, BIT(PATH_ALBEDO)},
        {LAYER_DIFFUSE_DIRECT, BIT(PATH_DIFFUSE_DIRECT)},
        {LAYER_DIFFUSE_INDIRECT, 0},
        {LAYER_OCCLUSION, BIT(AMBIENT_VISIBILITY) | BIT(AMBIENT_DISTANCE_MIN)},
        {LAYER_SAMPLES | LAYER_DEPTH | LAYER_NORMAL | LAYER_ID | LAYER_FILTER_WIDTH, 0},
    };
    struct stage *s = *state;
    s->material.specular = 1;
    s->job.occlusion_distance = 2;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        s->job.layers = cases[i].layer;
        must_make(s);
        assert_int_equal(s->plan.planes, PLANES_SURFACE | BIT(INDIRECT_MEAN) |
                                             BIT(BOUNCE_DISTANCE_MIN) | BIT(PATH_RADIANCE) |
                                             cases[i].planes);
        assert_true(s->plan.occlusion_distance ==
                    (cases[i].layer == LAYER_OCCLUSION ? 2.0f : 0.0f));
    }
    s->job.layers = LAYERS_AVAILABLE & ~LAYER_ERROR;
    must_make(s);
    assert_string_equal(why(s, "plane path_diffuse_indirect"), "a light field brings it");
    assert_string_equal(why(s, "plane path_visibility"), "a light field brings it");
    assert_null(why(s, "plane open"));
    /* Halves of both tell of errors, and change nothing of the mean. */
    s->job.layers = LAYERS_AVAILABLE;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_true(s->plan.planes & BIT(INDIRECT_HALVES) && s->plan.planes & BIT(BOUNCE_DISTANCE_MIN));
    assert_true(s->plan.planes & BIT(PATH_M2) && s->plan.planes & BIT(PATH_HALF_DIFFERENCE2));
    assert_true(s->plan.planes & BIT(INDIRECT_MEAN));
}

TEST(occlusion_stands_alone)
{
    struct stage *s = *state;
    s->job.layers = LAYER_BEAUTY | LAYER_OCCLUSION;
    s->job.occlusion_distance = 0.5f;
    s->job.indirect_bounces = 0;
    s->job.indirect_spp = 64;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LIGHT_FIELD);
    assert_int_equal(s->plan.planes,
                     PLANES_ALONE | BIT(AMBIENT_VISIBILITY) | BIT(BOUNCE_DISTANCE_MIN));
    assert_int_equal(s->plan.indirect_strata_per_axis, 8);
    assert_int_equal(s->plan.bounces, 0);
    assert_true(s->plan.occlusion_distance == 0.5f);
    assert_int_equal(s->report.effects & (EFFECT_OCCLUSION | EFFECT_INDIRECT), EFFECT_OCCLUSION);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_LINEAR);
    s->material.specular = 1;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_int_equal(s->plan.planes, PLANES_CENTRE | BIT(AMBIENT_VISIBILITY) |
                                         BIT(BOUNCE_DISTANCE_MIN) | BIT(PATH_RADIANCE) |
                                         BIT(PATH_COVERAGE));
    assert_int_equal(s->plan.paths.without_diffuse_indirect, 0);
    assert_int_equal(s->plan.sub_samples, 0);
    /* In the dark there is still something to see of it. */
    s->scene.count[SCENE_LIGHTS] = 0;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_true(s->plan.planes & BIT(AMBIENT_VISIBILITY));
    s->job.indirect = INDIRECT_AVERAGE;
    must_make(s);
    assert_false(s->plan.planes & BIT(BOUNCE_DISTANCE_MIN));
}

/* Under a name fields bring the soft share of a sky; average leaves them unfiltered. */
TEST(fields_bring_the_sky_by_name)
{
    static const enum environment_method methods[] = {ENVIRONMENT_AUTO, ENVIRONMENT_AVERAGE,
                                                      ENVIRONMENT_AXIS_ALIGNED};
    struct stage *s = *state;
    s->job.environment = (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .intensity = 1};
    for (int c = 0; c < 3; c++) s->job.environment.radiance[c] = 1;
    for (int k = 0; k < 3; k++) {
        s->job.environment_filter = methods[k];
        must_make(s);
        assert_int_equal(s->plan.paths.without_diffuse_indirect == INDIRECT_LEFT_SKY, k > 0);
        if (k > 0)
            assert_int_equal(s->plan.indirect_filter,
                             k == 2 ? INDIRECT_FILTER_CONSTANT : INDIRECT_FILTER_NONE);
        assert_false(has_warning(s, "filter.environment"));
    }
    s->material.specular = 1;
    s->material.roughness = 0.5f;
    for (int k = 1; k < 3; k++) { /* lobes' field has the sky's light, too */
        s->job.environment_filter = methods[k];
        must_make(s);
        assert_int_equal(s->plan.glossy_filter,
                         k == 2 ? GLOSSY_FILTER_VIRTUAL_HIT : GLOSSY_FILTER_NONE);
    }
    s->job.indirect = INDIRECT_AVERAGE;
    must_make(s);
    assert_true(has_warning(s, "the field that has its light is not filtered"));
    s->job.indirect = INDIRECT_AUTO;
    s->job.layers |= LAYER_INDIRECT;
    must_make(s);
    assert_true(has_warning(s, "the environment's soft light is indirect"));
    s->job.indirect_bounces = 0;
    must_make(s);
    assert_int_equal(s->plan.paths.without_diffuse_indirect, INDIRECT_LEFT_NONE);
    assert_true(has_warning(s, "paths bring the environment's light"));
    s->job.environment.kind = ENVIRONMENT_NONE;
    must_make(s);
    assert_true(has_warning(s, "there is no environment"));
}

/* Halves of floats hold what is bounced of an environment, bright or dark. */
TEST(scales_follow_the_environment)
{
    struct stage *s = *state;
    s->scene.count[SCENE_LIGHTS] = 0;
    static const float radiance[] = {1e-6f, 1, 1e6f};
    for (int i = 0; i < 3; i++) {
        s->job.environment = (struct job_environment){
            .kind = ENVIRONMENT_CONSTANT, .radiance = {radiance[i], radiance[i], radiance[i]}};
        must_make(s);
        const float most = 4 * radiance[i] * s->plan.radiance_scale;
        assert_true(most > 120 && most <= 256);
    }
}
