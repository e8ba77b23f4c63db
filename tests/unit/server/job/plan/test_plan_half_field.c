/* When fields have half the resolution, and what is said when they have not. */
#include "proto/half_field.h"
#include "tests/unit/server/job/plan/indirect_stage.h"

EACH_TEST(set_up, stage_tear_down);

#define FULL "fields have rays in all pixels"

static void ask(struct stage *s)
{
    s->job.field_scale = FIELD_SCALE_HALF;
}

TEST(fields_are_halved_when_asked)
{
    struct stage *s = *state;
    ask(s);
    for (uint32_t filter = INDIRECT_AUTO; filter <= INDIRECT_LINEAR; filter++) {
        if (filter == INDIRECT_AVERAGE) continue;
        s->job.indirect = (enum indirect_method)filter;
        must_make(s);
        assert_int_equal(s->plan.field_halved, 1);
        assert_false(has_warning(s, FULL));
    }
    s->material.specular = 1.0f; /* beside paths */
    must_make(s);
    assert_int_equal(s->plan.field_halved, 1);
    json_t *report = plan_report_json(&s->plan, &s->report);
    assert_true(
        json_real_value(json_object_get(json_object_get(report, "samples"), "field_scale")) == 0.5);
    json_decref(report);
}

/* A quarter of the rays is what filters count on. */
TEST(filters_count_on_a_quarter)
{
    struct stage *s = *state;
    ask(s);
    s->job.indirect_spp = 64;
    must_make(s);
    assert_int_equal(s->plan.indirect_strata_per_axis, 8);
    assert_true(half_field_rays(&s->plan) == 16.0f);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_CONSTANT);
    s->job.indirect_spp = 144;
    must_make(s);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_LINEAR);
}

static void expect_full(struct stage *s, const char *because)
{
    must_make(s);
    assert_int_equal(s->plan.field_halved, 0);
    assert_true(has_warning(s, FULL));
    assert_true(has_warning(s, because));
    s->job.field_scale = FIELD_SCALE_FULL;
    must_make(s);
    assert_false(has_warning(s, FULL));
    ask(s);
}

TEST(other_fields_need_all_rays)
{
    struct stage *s = *state;
    static const enum indirect_method others[] = {INDIRECT_AVERAGE, INDIRECT_BLEND,
                                                  INDIRECT_SHEARED};
    ask(s);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        s->job.indirect = others[i];
        expect_full(s, "constant and linear");
    }
    s->job.indirect = INDIRECT_ADAPTIVE;
    expect_full(s, "more rays by what they have");
    s->job.indirect = INDIRECT_CONSTANT;
    s->job.target_error = 0.1f;
    s->job.max_spp = 64;
    expect_full(s, "more rays by what they have");
    s->job.target_error = 0.0f;
    s->job.max_spp = 0;
    s->job.indirect_bounces = 0;
    expect_full(s, "no light field has bounce rays");
}

TEST(a_lens_needs_all_rays)
{
    struct stage *s = *state;
    ask(s);
    s->job.aperture_radius = 0.1f;
    s->job.focus_distance = 4;
    expect_full(s, "lens samples");
}

/* Layers that are asked for change no resolution. */
TEST(layers_change_nothing)
{
    struct stage *s = *state;
    ask(s);
    s->job.occlusion_distance = 1;
    for (uint32_t bit = 0; bit < 32; bit++) {
        const uint32_t layer = 1u << bit & (LAYER_ERROR | LAYER_OCCLUSION | LAYER_SAMPLES);
        s->job.layers = LAYER_BEAUTY | layer;
        must_make(s);
        assert_int_equal(s->plan.field_halved, 1);
        assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_CONSTANT);
    }
}
