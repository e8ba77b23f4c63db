/* Plans with a lens whose picture paths make, or that paths bring layers to. */
#include <string.h>

#include "tests/unit/server/job/plan/lens_stage.h"

EACH_TEST(set_up_lens, stage_tear_down);

static void expect_paths(struct stage *s, const char *sentence)
{
    const struct job job = s->job;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_int_equal(s->plan.lens_strata_per_axis, 0);
    assert_int_equal(s->plan.planes & PLANES_LENS, 0);
    assert_string_equal(s->report.lens_filter_why, sentence);
    assert_string_equal(why(s, "filter of the lens"), sentence);
    s->job.lens = LENS_AXIS_ALIGNED;
    must_make(s);
    assert_true(has_warning(s, "filter.lens is axis_aligned, but no lens samples are filtered: "));
    s->job = job;
}

TEST(paths_take_what_lens_samples_cannot)
{
    struct stage *s = *state;
    const struct job job = s->job;
    s->job.method = FILTER_NONE;
    expect_paths(s, "filter.method is none: samples are averaged");
    s->job = job;
    s->job.layers = LAYER_BEAUTY | LAYER_DIRECT | LAYER_ERROR;
    expect_paths(s, "with a lens only paths give the layer direct");
    s->job.layers = LAYER_BEAUTY | LAYER_ERROR;
    expect_paths(s, "with a lens only paths give the layer error");
    s->job = job;
    s->job.target_error = 0.1f;
    s->job.max_spp = 64;
    expect_paths(s, "sampling.target_error needs samples of known error");
    s->job = job;
    s->job.lens_spp = 289;
    expect_paths(s, "289 lens samples are more than the 256 that travel one by one");
    s->job.lens_spp = 256;
    s->job.width_px = s->job.height_px = 2048;
    expect_paths(s, "4194304 pixels of 3586 bytes of lens samples are above 4294967296 in all");
    s->job.lens_spp = 64;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
}

/* What the path machinery does by itself. */
TEST(any_scene_will_do)
{
    struct stage *s = *state;
    s->material.alpha_mode = ALPHA_BLEND;
    s->material.metallic = 0.5f;
    s->job.pixel_filter = PIXEL_FILTER_TENT;
    s->job.environment = (struct job_environment){.kind = ENVIRONMENT_MAP, .intensity = 1};
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
    assert_int_equal(s->plan.paths.pixel_filter, PIXEL_FILTER_TENT);
    s->scene.count[SCENE_LIGHTS] = 0;
    s->job.environment.kind = ENVIRONMENT_NONE;
    must_make(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_LENS_FIELD);
    assert_true(has_warning(s, "nothing lights this scene"));
}
