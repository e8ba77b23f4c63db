/* When glossy lobes have a light field, and which filter it takes. */
#include <string.h>

#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

#include "proto/samples.h"

#define BIT(plane) PLANE_BIT(plane)

static void must_make(struct stage *s)
{
    const struct plan_source source = {.scene = &s->scene, .map = &s->map};
    if (plan_make(&s->job, &source, 1, &s->plan, &s->report, &s->fault) != 0)
        fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
}

/* Without the residual filter, which would do without fields. */
static void varnish(struct stage *s)
{
    s->job.residual = RESIDUAL_NONE;
    s->material.specular = 1;
    s->material.roughness = 0.3f;
}

static const uint64_t half = PLANE_BIT(GLOSSY_HALF);
static const uint64_t always = PLANES_GLOSSY & ~PLANES_GLOSSY_AXES & ~PLANE_BIT(GLOSSY_HALF);

static void expect_field(struct stage *s, uint32_t filter, const char *why)
{
    must_make(s);
    assert_int_equal(s->plan.planes & PLANES_GLOSSY & ~half, always);
    assert_int_equal(s->plan.paths.without_glossy_indirect, 1);
    assert_int_equal(s->plan.paths.without_diffuse_indirect, 1);
    assert_int_equal(s->plan.glossy_filter, filter);
    assert_string_equal(s->report.glossy_filter_why, why);
}

static void expect_none(struct stage *s, const char *why)
{
    must_make(s);
    assert_int_equal(s->plan.planes & PLANES_GLOSSY, 0);
    assert_int_equal(s->plan.paths.without_glossy_indirect, 0);
    assert_int_equal(s->plan.glossy_filter, GLOSSY_FILTER_NONE);
    assert_string_equal(s->report.glossy_filter_why, why);
}

EACH_TEST(stage_set_up, stage_tear_down);

TEST(lobes_have_a_field)
{
    struct stage *s = *state;
    varnish(s);
    expect_field(s, GLOSSY_FILTER_VIRTUAL_HIT,
                 "9 rays a lobe: neighbours whose lobes see the same points need the fewest");
    s->material.specular = 0;
    s->material.metallic = 1;
    expect_field(s, GLOSSY_FILTER_VIRTUAL_HIT,
                 "9 rays a lobe: neighbours whose lobes see the same points need the fewest");
}

TEST(filters_are_taken_as_asked)
{
    struct stage *s = *state;
    varnish(s);
    s->job.glossy = GLOSSY_BANDLIMIT;
    expect_field(s, GLOSSY_FILTER_BANDLIMIT, "filter.glossy asks for it");
    s->job.glossy = GLOSSY_SG;
    expect_field(s, GLOSSY_FILTER_SG, "filter.glossy asks for it");
    s->job.glossy = GLOSSY_SG_MIXTURE;
    expect_field(s, GLOSSY_FILTER_SG_MIXTURE, "filter.glossy asks for it");
    s->job.glossy = GLOSSY_ASG;
    expect_field(s, GLOSSY_FILTER_ASG, "filter.glossy asks for it");
    s->job.glossy = GLOSSY_VIRTUAL_HIT;
    expect_field(s, GLOSSY_FILTER_VIRTUAL_HIT, "filter.glossy asks for it");
    s->job.glossy = GLOSSY_AVERAGE;
    expect_field(s, GLOSSY_FILTER_NONE, "filter.glossy is average");
    s->job.glossy = GLOSSY_AUTO;
    s->job.method = FILTER_AVERAGE;
    expect_field(s, GLOSSY_FILTER_NONE, "filter.method is average");
    s->job.glossy = GLOSSY_BANDLIMIT;
    expect_field(s, GLOSSY_FILTER_BANDLIMIT, "filter.glossy asks for it");
}

/* Their distances are sent where rays are dealt by them. */
TEST(spans_are_for_adaptive_sampling)
{
    struct stage *s = *state;
    varnish(s);
    must_make(s);
    assert_int_equal(s->plan.planes & PLANE_BIT(GLOSSY_SPAN), 0);
    s->job.indirect = INDIRECT_ADAPTIVE;
    must_make(s);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_ADAPTIVE);
    assert_true(s->plan.planes & PLANE_BIT(GLOSSY_SPAN));
    assert_int_equal(plan_strata_maps(&s->plan), 2);
    s->material.specular = s->material.metallic = 0;
    must_make(s);
    assert_int_equal(s->plan.planes & PLANE_BIT(GLOSSY_SPAN), 0);
    assert_int_equal(plan_strata_maps(&s->plan),
                     s->plan.indirect_filter == INDIRECT_FILTER_ADAPTIVE);
}

/* Nothing is traced or sent for lobes that no surface has. */
TEST(other_surfaces_have_none)
{
    struct stage *s = *state;
    static const char none[] = "no surface has a glossy lobe that is bare and not too sharp";
    varnish(s);
    s->material.transmission_texture.texture = s->material.anisotropy_texture.texture = SCENE_NONE;
    s->material.roughness = 0.09f;
    expect_none(s, none);
    s->material.roughness = 0.3f;
    s->material.transmission = 1;
    expect_none(s, none);
    s->material.transmission = 0;
    s->material.model = MODEL_PHONG;
    expect_none(s, none);
    s->job.glossy = GLOSSY_SG_MIXTURE;
    must_make(s);
    bool warned = false;
    for (uint32_t i = 0; i < s->report.warning_count; i++)
        warned |= strstr(s->report.warnings[i], "filter.glossy is sg_mixture, but") != NULL;
    assert_true(warned);
}

/* How lobes lie is sent where some are wider one way and the filter asks. */
TEST(axes_are_for_anisotropic_lobes)
{
    struct stage *s = *state;
    varnish(s);
    must_make(s);
    assert_int_equal(s->plan.planes & PLANES_GLOSSY_AXES, 0);
    s->material.anisotropy = 0.5f;
    must_make(s);
    assert_int_equal(s->plan.planes & PLANES_GLOSSY_AXES, PLANES_GLOSSY_AXES);
    s->job.glossy = GLOSSY_SG;
    must_make(s);
    assert_int_equal(s->plan.planes & PLANES_GLOSSY_AXES, 0);
    s->job.glossy = GLOSSY_ASG;
    must_make(s);
    assert_int_equal(s->plan.planes & PLANES_GLOSSY_AXES, PLANES_GLOSSY_AXES);
    static const uint32_t models[] = {MODEL_BECKMANN, MODEL_WARD, MODEL_ASHIKHMIN_SHIRLEY};
    for (int k = 0; k < 3; k++) {
        s->material.model = models[k];
        s->material.alpha_u = s->material.alpha_v = 0.2f;
        s->material.exponent_u = s->material.exponent_v = 20;
        must_make(s);
        assert_int_equal(s->plan.planes & PLANES_GLOSSY_AXES, 0);
        s->material.alpha_u = 0.3f;
        s->material.exponent_u = 30;
        must_make(s);
        assert_int_equal(s->plan.planes & PLANES_GLOSSY_AXES, PLANES_GLOSSY_AXES);
    }
}

/* Halves tell of errors, and cost nothing where nobody asks. */
TEST(halves_are_for_errors)
{
    struct stage *s = *state;
    static const char four[] =
        "4 rays a lobe: neighbours whose lobes see the same points need the fewest";
    varnish(s);
    s->job.spp = 4;
    expect_field(s, GLOSSY_FILTER_VIRTUAL_HIT, four);
    assert_false(s->plan.planes & half);
    s->job.layers = LAYER_BEAUTY | LAYER_ERROR;
    expect_field(s, GLOSSY_FILTER_VIRTUAL_HIT, four);
    assert_true(s->plan.planes & half);
    s->job.layers = LAYER_BEAUTY;
    s->job.target_error = 0.02f;
    s->job.max_spp = 64;
    expect_field(s, GLOSSY_FILTER_VIRTUAL_HIT, four);
    assert_true(s->plan.planes & half);
    s->job.glossy = GLOSSY_AVERAGE;
    must_make(s);
    assert_true(s->plan.planes & half);
}

TEST(other_plans_have_none)
{
    struct stage *s = *state;
    expect_none(s, "glossy lobes have a field beside paths and light fields only");
    varnish(s);
    s->job.method = FILTER_NONE;
    expect_none(s, "glossy lobes have a field beside paths and light fields only");
    s->job.method = FILTER_AUTO;
    s->job.layers = LAYER_BEAUTY | LAYER_OCCLUSION;
    s->job.occlusion_distance = 1;
    s->job.indirect_bounces = 0;
    expect_none(s, "there is no indirect light");
}

TEST(reports_it_as_json)
{
    struct stage *s = *state;
    varnish(s);
    s->job.residual = RESIDUAL_NONE;
    must_make(s);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_string_equal(json_string_value(json_object_get(json, "glossy_filter")), "virtual_hit");
    assert_string_equal(json_string_value(json_object_get(json, "glossy_filter_why")),
                        s->report.glossy_filter_why);
    const json_t *planes = json_object_get(json, "planes");
    const size_t count = json_array_size(planes);
    assert_string_equal(json_string_value(json_array_get(planes, count - 2)), "sub_reflectance");
    assert_string_equal(json_string_value(json_array_get(planes, count - 1)), "lone");
    json_decref(json);
}
