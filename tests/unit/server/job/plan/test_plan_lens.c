/* Plans with a lens: when its light field makes the picture, and with which filter. */
#include <math.h>
#include <string.h>

#include "proto/link/message.h"
#include "server/reconstruct/block.h"
#include "tests/unit/server/job/plan/lens_stage.h"

EACH_TEST(set_up_lens, stage_tear_down);

/* Of pixel centres that light lens samples, with indirect light that a filter runs over. */
#define PLANES_FIELD                                                                               \
    (BIT(DEPTH) | BIT(NORMAL) | BIT(ID) | BIT(INDIRECT_MEAN) | BIT(BOUNCE_DISTANCE_MIN))

TEST(lenses_have_light_fields)
{
    struct stage *s = *state;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
    assert_int_equal(s->plan.planes, PLANES_LENS | PLANES_FIELD);
    assert_int_equal(s->plan.lens_strata_per_axis, 3);
    assert_int_equal(s->plan.paths.spp, 0);
    assert_int_equal(s->plan.indirect_strata_per_axis, 3);
    assert_int_equal(s->plan.light_planes, LIGHT_PLANES_STRATA);
    assert_int_equal(s->plan.sub_samples, 0);
    assert_int_equal(s->plan.bounces, 1);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_DIFFUSE);
    assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_SHEARED);
    assert_int_equal(s->plan.indirect_filter, INDIRECT_FILTER_CONSTANT);
    assert_int_equal(s->plan.capabilities, CAPABILITY_LENS | CAPABILITY_PATHS | CAPABILITY_DIRECT |
                                               CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY);
    assert_int_equal(plan_pass_count(&s->plan), 1);
    assert_true(s->report.effects & EFFECT_LENS && s->report.effects & EFFECT_INDIRECT);
    assert_int_equal(s->report.warning_count, 0);
    assert_null(why(s, "light fields of pixel centres"));
    assert_null(why(s, "effect lens"));
}

/* Nothing of light fields is in a plan that has nothing for them to do. */
TEST(fields_light_samples_where_they_have_what_to_filter)
{
    struct stage *s = *state;
    const uint64_t own = PLANES_LENS & ~PLANES_LENS_SURFACE;
    for (int k = 0; k < 32; k++) {
        const bool area = k & 1, bounces = k & 2, filtered = k & 8, sky = k & 16;
        const bool lambert = (k & 4) && !sky; /* and lights of the list alone */
        s->job.environment = (struct job_environment){
            .kind = sky ? ENVIRONMENT_CONSTANT : ENVIRONMENT_NONE, .radiance = {1, 1, 1}};
        set_lamp(&s->lights[0]);
        if (!area) s->lights[0] = (struct scene_light){.type = LIGHT_POINT, .color = {1, 1, 1}};
        s->job.indirect_bounces = bounces ? 2 : 0;
        s->material.metallic = k & 4 ? 0.0f : 0.5f;
        s->material.roughness = 0.5f;
        s->job.lens = filtered ? LENS_AUTO : LENS_AVERAGE;
        s->job.residual = RESIDUAL_NONE;
        must_make(s);
        const uint32_t light = !filtered                      ? LENS_RELIGHT_OWN
                               : lambert && (area || bounces) ? LENS_RELIGHT_DIFFUSE
                               : sky && bounces               ? LENS_RELIGHT_SKY
                               : !lambert && bounces          ? LENS_RELIGHT_INDIRECT
                                                              : LENS_RELIGHT_OWN;
        const bool fields = light != LENS_RELIGHT_OWN, all = light == LENS_RELIGHT_DIFFUSE;
        assert_int_equal(s->plan.lens_relight, light);
        if (!fields)
            assert_int_equal(s->plan.planes & ~own, 0);
        else
            assert_int_equal(s->plan.planes & PLANES_LENS, PLANES_LENS);
        assert_int_equal((s->plan.planes & PLANES_BOUNCE_LIGHT) != 0, fields && bounces);
        const bool lobes =
            (light == LENS_RELIGHT_INDIRECT || light == LENS_RELIGHT_SKY) && !(k & 4);
        assert_int_equal((s->plan.planes & PLANE_BIT(LENS_LOBE)) != 0, lobes);
        assert_int_equal(s->plan.glossy_filter != GLOSSY_FILTER_NONE, lobes);
        assert_int_equal((s->plan.planes & PLANES_GLOSSY) != 0, lobes);
        assert_int_equal(s->plan.indirect_filter != INDIRECT_FILTER_NONE, fields && bounces);
        assert_int_equal(s->plan.light_planes != 0, all);
        assert_int_equal(s->plan.shadow_filter != SHADOW_FILTER_NONE, all && area);
        assert_int_equal(s->plan.sub_samples, 0);
        assert_true(s->report.lens_relight_why[0] != '\0');
        assert_int_equal(why(s, "light fields of pixel centres") == NULL, fields);
    }
}

/* Lobes of samples travel where there is room for them beside what else does. */
TEST(many_samples_leave_lobes_to_paths)
{
    struct stage *s = *state;
    s->material.metallic = s->material.roughness = 0.5f;
    s->job.spp = 16;
    s->job.residual = RESIDUAL_NONE;
    for (int k = 0; k < 2; k++) {
        s->job.width_px = 4000;
        s->job.height_px = k ? 2400 : 2100;
        must_make(s);
        assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_INDIRECT);
        assert_int_equal((s->plan.planes & PLANE_BIT(LENS_LOBE)) != 0, !k);
        assert_int_equal((s->plan.planes & PLANES_GLOSSY) != 0, !k);
    }
    assert_non_null(strstr(s->report.glossy_filter_why, "4294967296 bytes"));
}

/* Samples that no field lights are paths of the residual filter. */
TEST(samples_are_paths_where_fields_light_none)
{
    struct stage *s = *state;
    s->material.metallic = s->material.roughness = 0.5f;
    s->job.indirect_bounces = 2;
    for (uint32_t l = 2; l <= LIMIT_PLANE_STRATA_PER_AXIS; l++) {
        s->job.spp = l * l;
        must_make(s);
        assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
        assert_int_equal(s->plan.residual_filter, RESIDUAL_FILTER_HALVES);
        assert_int_equal(s->plan.planes & PLANES_RESIDUAL_READ, PLANES_RESIDUAL_READ);
        assert_true(plan_lens_has_paths(&s->plan) && s->plan.paths.spp == l * l);
        assert_int_equal(plan_pass_count(&s->plan), 1);
        assert_int_equal(s->plan.paths.edge_digits, 0);
    }
    s->job.spp = 1;
    must_make(s);
    assert_int_equal(s->plan.residual_filter, RESIDUAL_FILTER_NONE);
    s->job.spp = 9;
    s->job.lens_extra = 9;
    must_make(s);
    assert_true(s->plan.lens_extra == 9 && s->plan.paths.spp == 0);
    s->job.lens_extra = 0;
    s->job.indirect = INDIRECT_CONSTANT;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_INDIRECT);
    assert_int_equal(s->plan.paths.spp, 0);
    s->job.residual = RESIDUAL_HALVES;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
    assert_int_equal(s->plan.residual_filter, RESIDUAL_FILTER_HALVES);
    s->job.lens = LENS_AXIS_ALIGNED; /* beside which it does not run: fields light samples */
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_INDIRECT);
    assert_int_equal(s->plan.residual_filter, RESIDUAL_FILTER_NONE);
}

TEST(some_frames_keep_the_light_of_samples)
{
    struct stage *s = *state;
    s->job.indirect = INDIRECT_ADAPTIVE;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
    assert_non_null(strstr(s->report.lens_relight_why, "adaptive"));
    s->job.indirect = INDIRECT_AVERAGE;
    s->job.method = FILTER_AVERAGE;
    s->job.lens = LENS_SHEARED;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
    s->job.method = FILTER_AUTO;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_DIFFUSE);
    s->job.pixel_filter = PIXEL_FILTER_TENT;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
    assert_string_equal(s->report.lens_relight_why, "image.pixel_filter is not box");
}

/* Without a lens nothing of it is in the plan, whatever is said of it. */
TEST(pinholes_have_none)
{
    struct stage *s = *state;
    static struct plan plain;
    s->job.aperture_radius = s->job.focus_distance = 0;
    must_make(s);
    plain = s->plan;
    s->job.lens_spp = 64;
    s->job.lens = LENS_SHEARED;
    must_make(s);
    assert_memory_equal(&plain, &s->plan, sizeof plain);
    assert_int_equal(s->plan.planes & PLANES_LENS, 0);
    assert_int_equal(s->plan.lens_filter, LENS_FILTER_NONE);
    assert_string_equal(why(s, "effect lens"), "the camera is a pinhole");
    assert_string_equal(why(s, "filter of the lens"), "the camera is a pinhole");
    assert_string_equal(why(s, "sampling.lens_spp"), "the camera is a pinhole");
    assert_true(has_warning(s, "filter.lens is sheared, but no lens samples are filtered: "));
}

TEST(samples_are_those_asked_for)
{
    struct stage *s = *state;
    s->job.spp = 25;
    must_make(s);
    assert_int_equal(s->plan.lens_strata_per_axis, 5);
    s->job.lens_spp = 4;
    must_make(s);
    assert_int_equal(s->plan.lens_strata_per_axis, 2);
    s->job.lens_spp = 256;
    must_make(s);
    assert_int_equal(s->plan.lens_strata_per_axis, 16);
}

TEST(second_sets_are_planned)
{
    struct stage *s = *state;
    must_make(s);
    assert_int_equal(s->plan.lens_extra, 0);
    assert_false(plan_has_rounds(&s->plan));
    s->job.lens_extra = 9;
    must_make(s);
    assert_int_equal(s->plan.lens_extra, 9);
    assert_true(s->plan.planes & BIT(LENS_SECOND_SET) && plan_has_rounds(&s->plan));
    assert_true(s->plan.capabilities & CAPABILITY_STRATA_MAPS);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_DIFFUSE);
    assert_int_equal(plan_pass_planes(&s->plan, plan_pass_count(&s->plan)), PLANES_LENS_SECOND_SET);
    s->job.indirect = INDIRECT_ADAPTIVE; /* has a second set of its own, but none with a lens */
    must_make(s);
    assert_int_equal(s->plan.lens_extra, 9);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
    s->job.indirect = INDIRECT_AUTO;
    s->job.lens_spp = 1;
    must_make(s);
    assert_int_equal(s->plan.lens_extra, 0);
    assert_string_equal(why(s, "sampling.lens_extra"),
                        "one sample per pixel cannot tell which pixels need more");
    s->job.lens_spp = 9;
    s->job.lens = LENS_AXIS_ALIGNED;
    must_make(s);
    assert_true(s->plan.lens_extra == 0 && !(s->plan.planes & BIT(LENS_SECOND_SET)));
    assert_string_equal(why(s, "sampling.lens_extra"),
                        "only the sheared filter mixes second sets in");
    s->job.aperture_radius = s->job.focus_distance = 0;
    must_make(s);
    assert_int_equal(s->plan.lens_extra, 0);
    assert_string_equal(why(s, "sampling.lens_extra"), "the camera is a pinhole");
}

/* Of a large picture: a block of 64 pixels and all around it, with what is beside lens samples. */
TEST(blocks_fit_a_threads_memory)
{
    static const struct {
        uint32_t lens_spp;
        int32_t width_px, side_px; /* few large blocks would all wait for the last tile */
    } sides[] = {{9, 512, 128}, {9, 800, 256}, {49, 800, 256}, {64, 800, 128}, {144, 800, 64}};
    struct stage *s = *state;
    for (size_t k = 0; k < sizeof sides / sizeof sides[0]; k++) {
        s->job.lens_spp = sides[k].lens_spp;
        s->job.width_px = s->job.height_px = sides[k].width_px;
        must_make(s);
        assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_DIFFUSE);
        assert_int_equal(block_side_px(&s->plan), sides[k].side_px);
        const int32_t side = block_side_px(&s->plan) + 2 * block_halo_px(&s->plan);
        assert_true(patch_bytes(&s->plan, (size_t)side * (size_t)side) <= LIMIT_PATCH_BYTES);
    }
    s->job.lens_spp = 196;
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_OWN);
    assert_string_equal(s->report.lens_relight_why,
                        "a block's lens samples with their surfaces are above 268435456 bytes");
    assert_non_null(why(s, "light fields of pixel centres"));
    assert_int_equal(s->plan.residual_filter, RESIDUAL_FILTER_HALVES);
    assert_int_equal(block_side_px(&s->plan), 64);
    s->job.residual = RESIDUAL_NONE;
    must_make(s);
    assert_int_equal(block_side_px(&s->plan), 128); /* without surfaces */
    s->job.width_px = s->job.height_px = 128;       /* there is not so much around a block */
    must_make(s);
    assert_int_equal(s->plan.lens_relight, LENS_RELIGHT_DIFFUSE);
}

/* They are kept until all samples are known, with all that the plan has beside them. */
TEST(second_sets_are_left_out_where_samples_are_too_many)
{
    struct stage *s = *state;
    s->job.lens_extra = 9;
    s->job.lens_spp = 4;
    s->job.light_spp = 256;
    s->job.layers |= LAYER_VISIBILITY;
    for (int k = 0; k < LIMIT_LIGHTS; k++) set_lamp(&s->lights[k]);
    s->scene.count[SCENE_LIGHTS] = LIMIT_LIGHTS;
    s->job.width_px = s->job.height_px = 1024;
    must_make(s);
    assert_int_equal(s->plan.lens_extra, 9);
    s->job.width_px = s->job.height_px = 2048;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
    assert_int_equal(s->plan.lens_extra, 0);
    assert_false(plan_has_rounds(&s->plan) || s->plan.planes & BIT(LENS_SECOND_SET));
    assert_false(s->plan.capabilities & CAPABILITY_STRATA_MAPS);
    assert_non_null(why(s, "sampling.lens_extra"));
    assert_true(has_warning(s, "sampling.lens_extra is left out: 4194304 pixels keep "));
}

TEST(filters_are_taken_as_asked)
{
    struct stage *s = *state;
    static const struct {
        enum filter_method method;
        enum lens_method lens;
        uint32_t filter;
        const char *why;
    } cases[] = {
        {FILTER_AUTO, LENS_AUTO, LENS_FILTER_SHEARED,
         "filtering along the slopes of what is out of focus needs the fewest samples"},
        {FILTER_SHEARED, LENS_AUTO, LENS_FILTER_SHEARED, "filter.method asks for it"},
        {FILTER_AXIS_ALIGNED, LENS_AUTO, LENS_FILTER_AXIS_ALIGNED, "filter.method asks for it"},
        {FILTER_AVERAGE, LENS_AUTO, LENS_FILTER_NONE, "filter.method is average"},
        {FILTER_AUTO, LENS_AVERAGE, LENS_FILTER_NONE, "filter.lens is average"},
        {FILTER_SHEARED, LENS_AVERAGE, LENS_FILTER_NONE, "filter.lens is average"},
        {FILTER_AUTO, LENS_AXIS_ALIGNED, LENS_FILTER_AXIS_ALIGNED, "filter.lens asks for it"},
        {FILTER_AVERAGE, LENS_SHEARED, LENS_FILTER_SHEARED, "filter.lens asks for it"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        s->job.method = cases[k].method;
        s->job.lens = cases[k].lens;
        must_make(s);
        assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
        assert_int_equal(s->plan.lens_filter, cases[k].filter);
        assert_string_equal(s->report.lens_filter_why, cases[k].why);
        const bool none = cases[k].filter == LENS_FILTER_NONE;
        assert_int_equal((s->plan.planes & BIT(LENS_SLOPE)) != 0, !none);
        assert_int_equal(why(s, "filter of the lens") != NULL, none);
        assert_int_equal(why(s, "plane lens_slope") != NULL, none);
    }
}

TEST(layers_of_pixel_centres_have_their_planes)
{
    struct stage *s = *state;
    s->job.indirect = INDIRECT_ADAPTIVE; /* which leaves samples their light */
    s->job.residual = RESIDUAL_NONE;
    s->job.layers = LAYER_BEAUTY | LAYER_NORMAL | LAYER_ID | LAYER_SAMPLES | LAYER_FILTER_WIDTH;
    must_make(s);
    assert_int_equal(s->plan.planes,
                     (PLANES_LENS & ~PLANES_LENS_SURFACE) | BIT(DEPTH) | BIT(NORMAL) | BIT(ID));
    s->job.layers = LAYER_VISIBILITY | LAYER_SLOPE_MAX;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
    assert_int_equal(s->plan.planes, BIT(LENS_RADIANCE) | BIT(LENS_SLOPE) | BIT(DEPTH));
    assert_int_equal(s->plan.light_planes, 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES);
    assert_int_equal(s->plan.lights[0].strata_per_axis, 3);
}

/* Wherever the focus lies and however wide the lens, the plan is refused or can be traced. */
TEST(odd_lenses_are_refused_or_planned)
{
    struct stage *s = *state;
    static const float radii[] = {1e-30f, 1e-3f, 1, 1e4f, LIMIT_COORDINATE};
    static const float focuses[] = {1e-30f, 1e-3f, 1e6f, LIMIT_COORDINATE};
    for (size_t i = 0; i < sizeof radii / sizeof radii[0]; i++)
        for (size_t k = 0; k < sizeof focuses / sizeof focuses[0]; k++) {
            s->job.aperture_radius = radii[i];
            s->job.focus_distance = focuses[k];
            must_make(s);
            assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
        }
    static const float none[] = {0, -1, INFINITY, NAN};
    for (size_t k = 0; k < sizeof none / sizeof none[0]; k++) {
        s->job.focus_distance = none[k];
        assert_true(make(s) < 0);
        assert_string_equal(s->fault.pointer, "/lens");
    }
}

TEST(reports_the_lens_as_json)
{
    struct stage *s = *state;
    must_make(s);
    json_t *json = plan_report_json(&s->plan, &s->report);
    assert_non_null(json);
    assert_string_equal(json_string_value(json_object_get(json, "integrator")), "lens_field");
    assert_string_equal(json_string_value(json_object_get(json, "lens_filter")), "sheared");
    assert_string_equal(json_string_value(json_object_get(json, "lens_filter_why")),
                        s->report.lens_filter_why);
    const json_t *samples = json_object_get(json, "samples");
    assert_int_equal(json_integer_value(json_object_get(samples, "lens")), 9);
    assert_int_equal(json_integer_value(json_object_get(samples, "primary")), 1);
    assert_int_equal(json_integer_value(json_object_get(samples, "indirect")), 9);
    assert_string_equal(json_string_value(json_object_get(json, "lens_relight")), "diffuse");
    assert_string_equal(json_string_value(json_object_get(json, "lens_relight_why")),
                        "soft shadows and indirect light are filtered first, at pixel centres");
    assert_null(json_object_get(samples, "paths"));
    assert_string_equal(json_string_value(json_array_get(json_object_get(json, "planes"), 6)),
                        "lens_slope");
    json_decref(json);
}
