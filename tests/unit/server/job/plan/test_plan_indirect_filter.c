/* Which filter a plan runs over indirect light and occlusion, and why. */
#include <string.h>

#include "tests/unit/server/job/plan/indirect_stage.h"

EACH_TEST(set_up, stage_tear_down);

static void expect_filter(struct stage *s, uint32_t filter, const char *sentence)
{
    must_make(s);
    assert_int_equal(s->plan.indirect_filter, filter);
    assert_string_equal(s->report.indirect_filter_why, sentence);
    assert_true((filter == INDIRECT_FILTER_NONE) == (why(s, "filter of indirect light") != NULL));
    assert_true((filter != INDIRECT_FILTER_NONE) ==
                ((s->plan.planes & BIT(BOUNCE_DISTANCE_MIN)) != 0));
}

TEST(auto_filters_by_samples)
{
    struct stage *s = *state;
    static const struct {
        uint32_t spp, filter;
        const char *why;
    } cases[] = {
        {1, INDIRECT_FILTER_CONSTANT, "1 bounce ray: weighted means need the fewest"},
        {4, INDIRECT_FILTER_CONSTANT, "4 bounce rays: weighted means need the fewest"},
        {25, INDIRECT_FILTER_CONSTANT, "25 bounce rays: weighted means need the fewest"},
        {26, INDIRECT_FILTER_LINEAR, "36 bounce rays: linear fits blur less than means do"},
        {49, INDIRECT_FILTER_LINEAR, "49 bounce rays: linear fits blur less than means do"},
        {64, INDIRECT_FILTER_LINEAR, "64 bounce rays: linear fits blur less than means do"},
        {65536, INDIRECT_FILTER_LINEAR, "65536 bounce rays: linear fits blur less than means do"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        s->job.spp = 9;
        s->job.indirect_spp = cases[i].spp;
        expect_filter(s, cases[i].filter, cases[i].why);
        s->job.spp = cases[i].spp;
        s->job.indirect_spp = 0;
        expect_filter(s, cases[i].filter, cases[i].why);
    }
}

TEST(filters_are_taken_as_asked)
{
    struct stage *s = *state;
    static const char asked[] = "filter.indirect asks for it";
    for (int glossy = 0; glossy < 2; glossy++) {
        s->material.specular = (float)glossy;
        s->job.method = FILTER_AUTO;
        s->job.indirect = INDIRECT_CONSTANT;
        expect_filter(s, INDIRECT_FILTER_CONSTANT, asked);
        s->job.indirect = INDIRECT_LINEAR;
        expect_filter(s, INDIRECT_FILTER_LINEAR, asked);
        s->job.indirect = INDIRECT_BLEND;
        expect_filter(s, INDIRECT_FILTER_BLEND, asked);
        s->job.indirect = INDIRECT_AVERAGE;
        expect_filter(s, INDIRECT_FILTER_NONE, "filter.indirect is average");
        /* Of filter.method only average speaks of indirect light, and only where nothing else is
         * asked for. */
        s->job.indirect = INDIRECT_AUTO;
        s->job.method = FILTER_AXIS_ALIGNED;
        expect_filter(s, INDIRECT_FILTER_CONSTANT, "9 bounce rays: weighted means need the fewest");
        s->job.method = FILTER_AVERAGE;
        expect_filter(s, INDIRECT_FILTER_NONE, "filter.method is average");
        s->job.indirect = INDIRECT_LINEAR;
        expect_filter(s, INDIRECT_FILTER_LINEAR, asked);
    }
}

/* Adaptive sampling begins with 16 rays, whatever spp is; indirect_spp is the most. */
TEST(rates_follow_mu)
{
    struct stage *s = *state;
    static const struct {
        float mu;
        uint32_t indirect_spp, most;
    } cases[] = {{1, 0, 100}, {0.5f, 0, 100}, {2, 0, 400},     {100, 0, LIMIT_SPP},
                 {2, 64, 64}, {1, 16, 16},    {1, 1024, 1024}, {1, 9, 16}};
    s->job.indirect = INDIRECT_ADAPTIVE;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        s->job.mu = cases[i].mu;
        s->job.indirect_spp = cases[i].indirect_spp;
        must_make(s);
        assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_ADAPTIVE);
        assert_int_equal(s->plan.indirect_strata_per_axis, 4);
        assert_true(s->plan.adaptive.mu == cases[i].mu && s->plan.mu == 1.0f);
        assert_int_equal(s->plan.adaptive.rays_max, cases[i].most);
        assert_int_equal(s->plan.planes, PLANES_ALONE | BIT(INDIRECT_MEAN) |
                                             BIT(BOUNCE_DISTANCE_MIN) | BIT(BOUNCE_DISTANCE_MAX));
        assert_true(s->plan.capabilities & CAPABILITY_STRATA_MAPS);
        assert_true(plan_has_rounds(&s->plan));
        assert_int_equal(s->report.warning_count, cases[i].indirect_spp == 9 ? 1 : 0);
    }
    s->job.mu = 1;
    s->job.indirect_spp = 0;
    must_make(s);
    assert_string_equal(s->report.indirect_filter_why,
                        "filter.indirect asks for it: 16 rays a pixel, then as many as their "
                        "distances call for, 100 at most");
    json_t *report = plan_report_json(&s->plan, &s->report);
    json_t *adaptive = json_object_get(json_object_get(report, "samples"), "indirect_most");
    assert_int_equal(json_integer_value(adaptive), 100);
    json_decref(report);
    s->material.specular = 1; /* beside paths */
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_ADAPTIVE);
    assert_int_equal(s->plan.paths.spp, 9);
    s->job.indirect = INDIRECT_AUTO;
    must_make(s);
    assert_true(s->plan.adaptive.mu == 0 && s->plan.adaptive.rays_max == 0);
    assert_string_equal(why(s, "plane bounce_distance_max"), "no filter of this plan reads it");
}

/* Shear reads single rays, as many as travel; whatever else there is is filtered along the axes. */
TEST(shear_reads_single_rays)
{
    struct stage *s = *state;
    s->job.indirect = INDIRECT_SHEARED;
    for (int glossy = 0; glossy < 2; glossy++) {
        s->material.specular = (float)glossy;
        s->job.layers = LAYER_BEAUTY;
        s->job.indirect_spp = 256;
        must_make(s);
        assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_SHEARED);
        assert_int_equal(s->plan.planes & ~(BIT(PATH_RADIANCE) | BIT(PATH_COVERAGE)),
                         (glossy ? PLANES_SURFACE : PLANES_ALONE) | BIT(INDIRECT_STRATA) |
                             BIT(BOUNCE_DISTANCE_MIN));
        assert_int_equal(s->plan.paths.without_diffuse_indirect, (uint32_t)glossy);
        assert_true(s->plan.capabilities & CAPABILITY_STRATA);
        assert_string_equal(why(s, "plane indirect_mean"), "it is made of the strata");
        s->job.layers |= LAYER_OCCLUSION;
        s->job.occlusion_distance = 1;
        must_make(s);
        assert_true((s->plan.planes & (BIT(AMBIENT_VISIBILITY) | BIT(BOUNCE_DISTANCE_MIN))) ==
                    (BIT(AMBIENT_VISIBILITY) | BIT(BOUNCE_DISTANCE_MIN)));
        s->job.indirect_spp = 257;
        must_make(s);
        assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_LINEAR);
        assert_true(has_warning(s, "at most 256 a pixel: the filter is linear"));
        assert_false(s->plan.planes & BIT(INDIRECT_STRATA));
    }
}

TEST(paths_alone_are_not_filtered)
{
    struct stage *s = *state;
    s->job.method = FILTER_NONE;
    expect_filter(s, INDIRECT_FILTER_NONE, "filter.method is none: samples are averaged");
    assert_int_equal(s->report.warning_count, 0);
    s->job.indirect = INDIRECT_AVERAGE;
    must_make(s);
    assert_int_equal(s->report.warning_count, 0);
    s->job.indirect = INDIRECT_BLEND;
    must_make(s);
    assert_true(has_warning(s, "filter.indirect is blend, but indirect light is not filtered: "));
    s->job.method = FILTER_AUTO;
    s->job.aperture_radius = 0.1f;
    s->job.focus_distance = 4;
    expect_filter(s, INDIRECT_FILTER_BLEND, "filter.indirect asks for it");
    s->job.lens = LENS_AVERAGE;
    expect_filter(s, INDIRECT_FILTER_NONE,
                  "with a lens every sample is a path, with light of its own");
    assert_true(has_warning(s, "filter.indirect is blend, but"));
}

/* Who asked for a filter is told that there is nothing to filter, not what light fields cannot do.
 */
TEST(nothing_is_filtered_where_nothing_bounces)
{
    static const char sentence[] = "there is neither indirect light nor occlusion to filter";
    struct stage *s = *state;
    s->material.metallic = 0.5f;
    s->job.indirect = INDIRECT_LINEAR;
    s->job.indirect_bounces = 0;
    expect_filter(s, INDIRECT_FILTER_NONE, sentence);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_true(has_warning(s, sentence));
    assert_string_equal(s->report.filter_why,
                        "paths make the picture, because light fields cannot: "
                        "material 0 \"main\" is not Lambert");
}

static const char *text_of(const json_t *json, const char *key)
{
    return json_string_value(json_object_get(json, key));
}

TEST(reports_filters_as_json)
{
    struct stage *s = *state;
    s->material.specular = 1;
    s->job.layers = LAYER_BEAUTY | LAYER_OCCLUSION;
    s->job.occlusion_distance = 1;
    s->job.indirect_spp = 36;
    must_make(s);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_string_equal(text_of(json, "integrator"), "paths_and_light_field");
    assert_string_equal(text_of(json, "filter"), "none");
    assert_string_equal(text_of(json, "indirect_filter"), "linear");
    assert_non_null(strstr(text_of(json, "indirect_filter_why"), "36 bounce rays"));
    const json_t *samples = json_object_get(json, "samples");
    assert_int_equal(json_integer_value(json_object_get(samples, "indirect")), 36);
    assert_int_equal(json_integer_value(json_object_get(samples, "antialias")), 3);
    assert_int_equal(json_integer_value(json_object_get(samples, "paths")), 9);
    const json_t *planes = json_object_get(json, "planes");
    const size_t count = json_array_size(planes);
    assert_string_equal(json_string_value(json_array_get(planes, count - 3)), "ambient_visibility");
    assert_string_equal(json_string_value(json_array_get(planes, count - 2)),
                        "ambient_distance_min");
    json_decref(json);
}
