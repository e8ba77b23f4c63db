/* When what paths bring is filtered, why, and which planes that takes. */
#include "proto/lone.h"
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

#define HALF_INDIRECT (PLANE_BIT(PATH_HALF_INDIRECT) | PLANE_BIT(PATH_DIFFUSE_INDIRECT))

EACH_TEST(stage_set_up, stage_tear_down);

/* Makes the plan, which must be one that workers take. */
static void expect(struct stage *s, uint32_t filter, const char *why)
{
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    if (plan_check(&s->plan, &s->fault) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    assert_int_equal(s->plan.residual_filter, filter);
    assert_string_equal(s->report.residual_filter_why, why);
    if (filter == RESIDUAL_FILTER_NONE) assert_int_equal(s->plan.planes & PLANES_RESIDUAL, 0);
    if (filter == RESIDUAL_FILTER_NONE) return;
    assert_int_equal(s->plan.planes & PLANES_RESIDUAL_READ, PLANES_RESIDUAL_READ);
}

static void expect_halves(struct stage *s)
{
    expect(s, RESIDUAL_FILTER_HALVES,
           "light that no light field covers comes along paths and is noisy");
}

static void expect_oidn(struct stage *s)
{
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    if (plan_check(&s->plan, &s->fault) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    assert_int_equal(s->plan.residual_filter, RESIDUAL_FILTER_OIDN);
    assert_string_equal(s->report.residual_filter_why,
                        "filter.residual is oidn, whose bytes differ from machine to machine");
    assert_int_equal(s->plan.planes & PLANES_OIDN_READ, PLANES_OIDN_READ);
    assert_int_equal(s->plan.planes & PLANES_RESIDUAL, PLANE_BIT(PATH_NORMAL));
}

/* A surface that no light field covers. */
static void only_paths(struct stage *s)
{
    s->material.alpha_mode = ALPHA_BLEND;
}

TEST(auto_filters_paths)
{
    struct stage *s = *state;
    only_paths(s);
    s->job.indirect_bounces = 3;
    expect_halves(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, HALF_INDIRECT);
    static const uint32_t layers[] = {LAYER_DIFFUSE_DIRECT, LAYER_DIFFUSE_INDIRECT};
    for (int k = 0; k < 2; k++) {
        s->job.layers = layers[k];
        expect_halves(s);
    }
}

/* Lights that paths have to find: those that no light field brings. */
static void light_around(struct stage *s)
{
    s->material.metallic = 0.5f;
    s->job.scene_lights = false;
    s->job.environment =
        (struct job_environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    s->job.indirect_bounces = 2;
}

/* Where light fields cannot do it alone, whole paths are cheaper; a filter of theirs that is asked
 * for by name runs beside paths. */
TEST(whole_paths_do_without_light_fields)
{
    struct stage *s = *state;
    light_around(s);
    expect_halves(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, HALF_INDIRECT);
    s->job.layers = LAYER_BEAUTY | LAYER_OCCLUSION;
    s->job.occlusion_distance = 1;
    expect_halves(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_true(s->plan.planes & PLANE_BIT(AMBIENT_VISIBILITY));
    assert_false(s->plan.paths.without_diffuse_indirect);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, HALF_INDIRECT);
    s->job.layers = LAYER_BEAUTY;
    s->job.spp = 1;
    expect_halves(s);
    assert_false(s->plan.paths.without_diffuse_indirect);
}

static bool is_mixed(struct stage *s)
{
    expect_halves(s);
    const bool mixed = (s->plan.planes & PLANE_BIT(MIXED)) != 0;
    if (mixed) assert_int_equal(s->plan.planes & PLANES_CENTRE, PLANES_CENTRE);
    return mixed;
}

/* Also beside layers that light fields bring: looking at them changes no other pixel. */
TEST(whole_paths_have_mixed_pixels)
{
    struct stage *s = *state;
    light_around(s);
    assert_true(is_mixed(s));
    assert_int_equal(s->plan.paths.edge_digits, s->plan.paths.spp <= 4 ? 2 : 1);
    s->job.spp = s->plan.paths.spp <= 4 ? 9 : 4;
    assert_true(is_mixed(s));
    assert_int_equal(s->plan.paths.edge_digits, s->plan.paths.spp <= 4 ? 2 : 1);
    s->job.layers = LAYER_BEAUTY | LAYER_ERROR;
    assert_true(is_mixed(s));
    s->job.layers = LAYER_BEAUTY | LAYER_OCCLUSION;
    s->job.occlusion_distance = 1;
    assert_true(is_mixed(s));
    s->job.layers = LAYER_BEAUTY;
    s->job.target_error = 0.1f, s->job.max_spp = 64;
    assert_true(is_mixed(s));
    assert_int_equal(s->plan.paths.edge_digits, 2);
    s->job.target_error = 0.0f, s->job.max_spp = 0;
    s->job.indirect = INDIRECT_CONSTANT;
    assert_false(is_mixed(s));
    s->job.indirect = INDIRECT_AUTO;
    s->material.alpha_mode = ALPHA_BLEND;
    assert_true(is_mixed(s));
}

static void expect_lobes_divided(struct stage *s)
{
    expect_halves(s);
    assert_true(s->report.by_lobe);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_true(s->plan.paths.without_diffuse_direct && s->plan.paths.spp > 1);
    assert_int_equal(s->plan.paths.without_diffuse_indirect, s->plan.bounces > 0);
    assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_SHEARED);
    assert_true(s->plan.light_planes >> LIGHT_PLANE_DIFFUSE_WEIGHT & 1u);
    assert_true(s->plan.planes & PLANE_BIT(LONE) && s->plan.planes & PLANE_BIT(MIXED));
    assert_true(lone_parts(&s->plan) >> LONE_DIRECT & 1u);
}

/* Where all that shines is listed, fields bring what diffuse lobes send on, whatever lobes some
 * surfaces have besides, and whatever layers are asked for. */
TEST(fields_and_paths_divide_lobes)
{
    static const uint32_t layers[] = {LAYER_BEAUTY, LAYER_BEAUTY | LAYER_ERROR,
                                      LAYER_BEAUTY | LAYER_OCCLUSION,
                                      LAYER_BEAUTY | LAYER_DIRECT | LAYER_EMISSION | LAYER_ALBEDO};
    struct stage *s = *state;
    s->material.metallic = 0.5f;
    s->job.occlusion_distance = 1;
    for (uint32_t bounces = 0; bounces <= 2; bounces += 2)
        for (int k = 0; k < 4; k++) {
            s->job.indirect_bounces = bounces;
            s->job.layers = layers[k];
            expect_lobes_divided(s);
            assert_false(s->plan.planes & (PLANE_BIT(PATH_EMISSION) * (k == 3)) &
                         ~PLANES_RESIDUAL_READ);
        }
    s->job.layers = LAYER_BEAUTY;
    s->job.target_error = 0.1f, s->job.max_spp = 64;
    expect_halves(s);
    assert_false(s->report.by_lobe);
    s->job.target_error = 0.0f, s->job.max_spp = 0;
    light_around(s);
    expect_halves(s);
    assert_false(s->report.by_lobe);
}

static void shine(struct stage *s, bool sky, bool mesh)
{
    for (int c = 0; c < 3; c++) s->material.emission[c] = mesh ? 1.0f : 0.0f;
    s->job.environment = (struct job_environment){
        .kind = sky ? ENVIRONMENT_CONSTANT : ENVIRONMENT_NONE, .radiance = {1, 1, 1}};
}

/* Beside other lights fields bring direct light of those that are listed, on whatever surfaces, and
 * paths all else, the same whatever layers are asked for. */
TEST(fields_and_paths_divide_lights)
{
    static const uint32_t layers[] = {LAYER_BEAUTY, LAYER_BEAUTY | LAYER_ERROR,
                                      LAYER_BEAUTY | LAYER_DIRECT | LAYER_EMISSION | LAYER_ALBEDO,
                                      LAYER_BEAUTY | LAYER_OCCLUSION};
    struct stage *s = *state;
    s->job.indirect_bounces = 2;
    s->job.occlusion_distance = 1;
    for (int shines = 1; shines < 4; shines++)
        for (int k = 0; k < 8; k++) {
            s->material.metallic = k < 4 ? 0.0f : 0.5f;
            s->job.layers = layers[k % 4];
            shine(s, shines & 1, shines & 2);
            expect_halves(s);
            assert_true(s->report.by_light && s->report.by_lobe);
            assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
            assert_int_equal(s->plan.paths.without_diffuse_direct, DIRECT_LEFT_LISTED);
            assert_int_equal(s->plan.paths.without_diffuse_indirect, 0);
            assert_int_equal(s->plan.planes & PLANES_BOUNCE_LIGHT, 0);
            assert_int_equal(s->plan.planes & HALF_INDIRECT, HALF_INDIRECT);
            assert_int_equal(s->plan.shadow_filter, SHADOW_FILTER_SHEARED);
            assert_true(s->plan.planes & PLANE_BIT(LONE) && s->plan.planes & PLANE_BIT(MIXED));
            if (k % 4 == 2) assert_true(s->plan.planes & PLANE_BIT(PATH_DIRECT));
        }
}

/* What is asked for by name, targets, many samples, volumes and unlit lights keep paths whole. */
TEST(lights_are_not_always_divided)
{
    struct stage *s = *state;
    const struct scene_material lambert = s->material;
    const struct job job = s->job;
#define WHOLE(change)                                                                              \
    do {                                                                                           \
        shine(s, true, false);                                                                     \
        s->job.indirect_bounces = 2;                                                               \
        change;                                                                                    \
        assert_int_equal(make(s), 0);                                                              \
        assert_false(s->report.by_light);                                                          \
        assert_int_equal(s->plan.paths.without_diffuse_direct, DIRECT_LEFT_NONE);                  \
        s->material = lambert;                                                                     \
        s->job = job;                                                                              \
    } while (0)
    WHOLE(s->job.indirect = INDIRECT_CONSTANT);
    WHOLE(s->job.glossy = GLOSSY_VIRTUAL_HIT);
    WHOLE(s->job.method = FILTER_AVERAGE);
    WHOLE(s->job.residual = RESIDUAL_NONE);
    WHOLE(s->job.spp = 49);
    WHOLE((shine(s, false, true), s->job.spp = 121));
    WHOLE((s->job.target_error = 0.1f, s->job.max_spp = 64));
    WHOLE((s->material.transmission = 1.0f, s->material.thickness = 1.0f));
    WHOLE(s->job.scene_lights = false);
#undef WHOLE
    for (int mesh = 0; mesh < 2; mesh++) {
        shine(s, true, mesh);
        s->job.spp = mesh ? 100 : 36;
        assert_int_equal(make(s), 0);
        assert_true(s->report.by_light);
    }
}

/* Paths are as exact about lights without area. */
TEST(points_are_divided_for_few_samples)
{
    struct stage *s = *state;
    s->lights[0].type = LIGHT_DIRECTIONAL;
    for (uint32_t spp = 16; spp <= 25; spp += 9) {
        shine(s, true, true);
        s->job.spp = spp;
        assert_int_equal(make(s), 0);
        assert_true(s->report.by_light == (spp == 16));
    }
}

/* What no filter of paths cleans, fields bring if they can. */
TEST(unfiltered_paths_have_fields_of_indirect_light)
{
    struct stage *s = *state;
    shine(s, true, false);
    s->job.indirect_bounces = 2;
    s->job.spp = 1;
    assert_int_equal(make(s), 0);
    assert_true(s->report.by_light);
    assert_int_equal(s->plan.paths.without_diffuse_indirect, 0);
    s->job.residual = RESIDUAL_NONE;
    assert_int_equal(make(s), 0);
    assert_true(s->report.by_light);
    assert_int_equal(s->plan.paths.without_diffuse_direct, DIRECT_LEFT_LISTED);
    assert_int_equal(s->plan.paths.without_diffuse_indirect, 1);
    assert_true(s->plan.planes & PLANE_BIT(INDIRECT_MEAN));
}

/* Surfaces with normal maps are paths' alone, which then have diffuse light to filter, too. */
TEST(bumps_are_left_to_paths)
{
    struct stage *s = *state;
    s->material.metallic = 0.5f;
    s->job.indirect_bounces = 2;
    expect_lobes_divided(s);
    assert_false(s->report.bumpy);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, 0);
    s->material.normal_texture.texture = 0;
    expect_lobes_divided(s);
    assert_true(s->report.bumpy);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, HALF_INDIRECT);
}

TEST(fields_run_beside_paths_by_name)
{
    struct stage *s = *state;
    s->material.metallic = 0.5f;
    s->job.indirect_bounces = 2;
    s->job.indirect = INDIRECT_CONSTANT;
    expect_halves(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS_AND_LIGHT_FIELD);
    assert_true(s->plan.paths.without_diffuse_indirect);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, 0);
    s->job.layers = LAYER_BEAUTY | LAYER_DIFFUSE_INDIRECT;
    expect_halves(s);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, 0);
}

/* Sums and their halves come together, also where nothing is scattered twice. */
TEST(no_bounces_have_no_halves)
{
    struct stage *s = *state;
    only_paths(s);
    s->job.indirect_bounces = 0;
    expect_halves(s);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, 0);
    s->job.layers = LAYER_BEAUTY | LAYER_DIFFUSE_INDIRECT;
    expect_halves(s);
    assert_int_equal(s->plan.planes & HALF_INDIRECT, HALF_INDIRECT);
}

TEST(none_leaves_paths_alone)
{
    struct stage *s = *state;
    s->job.method = FILTER_NONE;
    expect(s, RESIDUAL_FILTER_NONE, "filter.method is none");
    s->job.method = FILTER_AVERAGE;
    only_paths(s);
    expect(s, RESIDUAL_FILTER_NONE, "filter.method is average");
    s->job.method = FILTER_AUTO;
    s->job.residual = RESIDUAL_NONE;
    expect(s, RESIDUAL_FILTER_NONE, "filter.residual is none");
}

TEST(halves_are_taken_by_name)
{
    static const enum filter_method methods[] = {FILTER_NONE, FILTER_AUTO, FILTER_AVERAGE};
    struct stage *s = *state;
    only_paths(s);
    s->job.residual = RESIDUAL_HALVES;
    for (int k = 0; k < 3; k++) {
        s->job.method = methods[k];
        expect(s, RESIDUAL_FILTER_HALVES, "filter.residual is halves");
    }
}

TEST(there_may_be_nothing_to_filter)
{
    struct stage *s = *state;
    for (int named = 0; named < 2; named++) {
        s->material.alpha_mode = ALPHA_OPAQUE;
        s->job.residual = named ? RESIDUAL_HALVES : RESIDUAL_AUTO;
        s->job.layers = LAYER_BEAUTY;
        s->job.spp = 9;
        expect(s, RESIDUAL_FILTER_NONE, "no light comes along paths");
        only_paths(s);
        s->job.layers = LAYER_DIRECT | LAYER_ALBEDO | LAYER_ERROR;
        expect(s, RESIDUAL_FILTER_NONE, "no layer shows what it filters");
    }
}

/* The whole frame goes to Open Image Denoise: paths with albedo and normals, at edges more of them,
 * and no halves. */
TEST(oidn_is_taken_by_name)
{
    static const enum filter_method methods[] = {FILTER_NONE, FILTER_AUTO, FILTER_AVERAGE};
    struct stage *s = *state;
    only_paths(s);
    s->job.residual = RESIDUAL_OIDN;
    for (int k = 0; k < 3; k++)
        for (uint32_t spp = 1; spp <= 4; spp += 3) {
            s->job.method = methods[k];
            s->job.spp = spp;
            expect_oidn(s);
            assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
            assert_true(s->plan.paths.edge_digits > 0);
        }
}

/* Fields still bring what they can, and what is left is filtered. */
TEST(oidn_stands_beside_fields)
{
    struct stage *s = *state;
    s->material.metallic = 0.5f;
    s->job.residual = RESIDUAL_OIDN;
    expect_oidn(s);
    assert_true(s->report.by_lobe);
    s->material.metallic = 0.0f;
    expect(s, RESIDUAL_FILTER_NONE, "no light comes along paths");
    only_paths(s);
    s->job.layers = LAYER_DIRECT | LAYER_DIFFUSE_DIRECT;
    expect(s, RESIDUAL_FILTER_NONE, "oidn filters the layer beauty alone");
}

/* It takes pixels, not lens samples, and each frame by itself. */
TEST(oidn_takes_paths_through_the_lens_and_single_frames)
{
    struct stage *s = *state;
    s->job.residual = RESIDUAL_OIDN;
    s->job.aperture_radius = 0.1f;
    s->job.focus_distance = 2;
    s->job.frames[0].last = 3;
    s->job.temporal = TEMPORAL_TWO;
    expect_oidn(s);
    assert_int_equal(s->report.integrator, INTEGRATOR_PATHS);
    assert_int_equal(s->plan.lens_strata_per_axis, 0);
    assert_int_equal(s->plan.temporal, 0);
    assert_string_equal(s->report.temporal_why, "filter.residual is oidn");
}
