/* When frames use samples of the frames beside them, of how many, and why not. */
#include <string.h>

#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

EACH_TEST(stage_set_up, stage_tear_down);

/* Paths that are filtered, in ten frames. */
static struct stage *sequence(void **state)
{
    struct stage *s = *state;
    s->material.alpha_mode = ALPHA_BLEND;
    s->job.frames[0] = (struct job_frame_run){1, 10, 1};
    return s;
}

static void expect(struct stage *s, uint32_t frames, const char *why)
{
    const uint64_t finds = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID);
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    if (plan_check(&s->plan, &s->fault) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    assert_int_equal(s->plan.temporal, frames);
    if (!strstr(s->report.temporal_why, why)) fail_msg("\"%s\"", s->report.temporal_why);
    if (frames > 0) assert_int_equal(s->plan.planes & finds, finds);
    assert_true((plan_window_bytes(&s->plan) > 0) == (frames > 0));
}

TEST(sequences_have_two_frames_on_each_side)
{
    struct stage *s = sequence(state);
    expect(s, 2, "samples of the same light");
    assert_int_equal(s->report.warning_count, 0);
}

TEST(a_frame_by_itself_has_none)
{
    struct stage *s = sequence(state);
    s->job.frames[0].last = 1;
    for (s->job.temporal = TEMPORAL_AUTO; s->job.temporal <= TEMPORAL_TWO; s->job.temporal++) {
        expect(s, 0, "one frame");
        assert_int_equal(s->report.warning_count, 0);
    }
}

TEST(as_many_as_are_named)
{
    struct stage *s = sequence(state);
    s->job.temporal = TEMPORAL_NONE;
    expect(s, 0, "filter.temporal is none");
    s->job.temporal = TEMPORAL_ONE;
    expect(s, 1, "asks for them");
    s->job.temporal = TEMPORAL_TWO;
    expect(s, 2, "asks for them");
}

/* Named, a warning says so, too. */
TEST(what_cannot_have_them_says_why)
{
    struct stage *s = sequence(state);
    for (int named = 0; named < 2; named++) {
        s->job.temporal = named ? TEMPORAL_TWO : TEMPORAL_AUTO;
        s->job.residual = RESIDUAL_NONE;
        expect(s, 0, "residual filter");
        assert_int_equal(s->report.warning_count, named);
        s->job.residual = RESIDUAL_AUTO;
        s->job.target_error = 0.1f, s->job.max_spp = 64;
        expect(s, 0, "tiles differ");
        s->job.target_error = 0, s->job.max_spp = 0;
        s->job.spp = 1;
        expect(s, 0, "one path a pixel");
        s->job.spp = 9;
        s->material.alpha_mode = ALPHA_OPAQUE;
        s->job.method = FILTER_SHEARED;
        expect(s, 0, "residual filter");
        s->job.method = FILTER_AUTO;
        s->material.alpha_mode = ALPHA_BLEND;
    }
}

TEST(large_pictures_have_as_many_as_fit)
{
    struct stage *s = sequence(state);
    uint32_t before = 2;
    for (s->job.width_px = s->job.height_px = 512; s->job.width_px <= 8192;
         s->job.width_px *= 2, s->job.height_px *= 2) {
        if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
        assert_true(s->plan.temporal <= before);
        assert_true(plan_window_bytes(&s->plan) <= LIMIT_WINDOW_BYTES);
        if (s->plan.temporal < 2) assert_non_null(strstr(s->report.temporal_why, "bytes"));
        before = s->plan.temporal;
    }
    assert_int_equal(before, 0);
}

/* Whether all light of an opaque scene under a lamp comes along paths, which fields could bring. */
static bool is_of_paths(struct stage *s)
{
    s->material.alpha_mode = ALPHA_OPAQUE;
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    const struct plan *p = &s->plan;
    const bool paths =
        p->paths.spp > 0 && !p->paths.without_diffuse_direct && !p->paths.without_diffuse_indirect;
    assert_true(paths == (p->temporal > 0));
    assert_true(paths == !p->shadow_filter);
    return paths;
}

TEST(frames_that_lend_each_other_samples_are_of_paths)
{
    struct stage *s = sequence(state);
    s->job.indirect_bounces = 2;
    assert_true(is_of_paths(s));
    assert_non_null(strstr(s->report.filter_why, "flicker"));
    s->material.specular = 1;
    assert_true(is_of_paths(s));
    s->material.specular = 0;
    s->job.temporal = TEMPORAL_NONE;
    assert_false(is_of_paths(s));
}

/* To look at occlusion changes no light. */
TEST(occlusion_of_such_frames_has_rays_of_its_own)
{
    struct stage *s = sequence(state);
    s->job.indirect_bounces = 2;
    s->job.layers |= LAYER_OCCLUSION;
    s->job.occlusion_distance = 1;
    assert_true(is_of_paths(s));
    assert_true(s->plan.planes & PLANE_BIT(AMBIENT_VISIBILITY));
}

TEST(frames_that_lend_nothing_are_of_light_fields)
{
    struct stage *s = sequence(state);
    s->job.frames[0] = (struct job_frame_run){1, 1, 1};
    assert_false(is_of_paths(s));
    s->job.frames[0] = (struct job_frame_run){1, 10, 1};
    s->job.spp = 1;
    assert_false(is_of_paths(s));
    s->job.spp = 9;
    s->job.width_px = s->job.height_px = 8192;
    assert_false(is_of_paths(s));
    s->job.width_px = s->job.height_px = 64;
    assert_true(is_of_paths(s));
}

TEST(fields_that_are_named_light_sequences_too)
{
    struct stage *s = sequence(state);
    s->job.indirect_bounces = 2;
    s->job.indirect = INDIRECT_LINEAR;
    assert_false(is_of_paths(s));
    s->job.indirect = INDIRECT_AUTO;
    s->job.indirect_spp = 9;
    assert_false(is_of_paths(s));
    s->job.indirect_spp = 0;
    s->job.light_spp = 9;
    assert_false(is_of_paths(s));
    s->job.light_spp = 0;
    s->job.method = FILTER_AXIS_ALIGNED;
    assert_false(is_of_paths(s));
    s->job.method = FILTER_AUTO;
    s->job.field_scale = FIELD_SCALE_HALF;
    assert_false(is_of_paths(s));
}

static bool is_lens_field(struct stage *s)
{
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    assert_true((s->plan.temporal == 0) == (s->report.integrator == INTEGRATOR_LENS_FIELD));
    return s->plan.temporal == 0;
}

/* What is blurred moves in no way that is known, unless it stands. */
TEST(a_lens_lends_samples_where_the_camera_stands)
{
    struct stage *s = sequence(state);
    s->job.aperture_radius = 0.1f, s->job.focus_distance = 5;
    assert_true(is_lens_field(s));
    s->camera_stands = true;
    assert_false(is_lens_field(s));
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_non_null(strstr(s->report.lens_filter_why, "flicker"));
    s->job.frames[0].step = 2;
    assert_true(is_lens_field(s));
}

TEST(fields_of_lenses_that_are_named_light_sequences_too)
{
    struct stage *s = sequence(state);
    s->job.aperture_radius = 0.1f, s->job.focus_distance = 5;
    s->camera_stands = true;
    s->job.lens_spp = 16;
    assert_true(is_lens_field(s));
    s->job.lens_spp = 0;
    s->job.lens_extra = 1;
    assert_true(is_lens_field(s));
    s->job.lens_extra = 0;
    s->job.lens = LENS_SHEARED;
    assert_true(is_lens_field(s));
}
