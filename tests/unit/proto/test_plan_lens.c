/* The lens of a plan: its shape, its samples with their light, mirrors and second sets. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

TEST(lenses_are_checked)
{
    EXPECT(plan.camera.aperture_radius = -1, ERR_RANGE, "camera.aperture_radius");
    EXPECT(plan.camera.aperture_radius = NAN, ERR_NOT_FINITE, "camera.aperture_radius");
    EXPECT(plan.camera.aperture_radius = 2e15f, ERR_RANGE, "camera.aperture_radius");
    EXPECT(plan.camera.focus_distance = 0, ERR_RANGE, "camera.focus_distance");
    EXPECT(plan.camera.focus_distance = -4, ERR_RANGE, "camera.focus_distance");
    EXPECT(plan.camera.focus_distance = INFINITY, ERR_NOT_FINITE, "camera.focus_distance");
    EXPECT((plan.camera.focus_distance = 0, without_lens(&plan)), ERR_OK, "");
    EXPECT(plan.camera.blade_count = 0, ERR_OK, "");
    EXPECT(plan.camera.blade_count = 2, ERR_RANGE, "camera.blade_count");
    EXPECT(plan.camera.blade_count = 3, ERR_OK, "");
    EXPECT(plan.camera.blade_count = LIMIT_LENS_BLADES, ERR_OK, "");
    EXPECT(plan.camera.blade_count = LIMIT_LENS_BLADES + 1, ERR_LIMIT, "camera.blade_count");
    EXPECT(plan.camera.blade_rotation_rad = NAN, ERR_NOT_FINITE, "camera.blade_rotation_rad");
    EXPECT(plan.camera.type = CAMERA_ORTHOGRAPHIC, ERR_RANGE, "camera.aperture_radius");
}

/* Samples of the lens belong to a lens and have a radiance; filters of them read slopes. */
TEST(lens_samples_are_checked)
{
    const uint64_t radiance = PLANE_BIT(LENS_RADIANCE), slope = PLANE_BIT(LENS_SLOPE);
    EXPECT(plan.lens_strata_per_axis = 1, ERR_OK, "");
    EXPECT(plan.lens_strata_per_axis = LIMIT_PLANE_STRATA_PER_AXIS, ERR_OK, "");
    EXPECT(plan.lens_strata_per_axis = 0, ERR_RANGE, "lens_strata_per_axis");
    EXPECT(plan.lens_strata_per_axis = LIMIT_PLANE_STRATA_PER_AXIS + 1, ERR_LIMIT,
           "lens_strata_per_axis");
    EXPECT(plan.planes &= ~radiance, ERR_LIMIT, "lens_strata_per_axis");
    EXPECT((plan.planes &= ~radiance, plan.lens_strata_per_axis = 0), ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~slope, ERR_RANGE, "planes");
    EXPECT(
        (plan.planes &= ~(slope | PLANES_LENS_SURFACE), plan.lens_relight = 0, plan.paths.spp = 4),
        ERR_OK, "");
    EXPECT((plan.planes &= ~PLANES_LENS_SURFACE, plan.lens_relight = 0, plan.paths.spp = 4), ERR_OK,
           "");
    EXPECT((plan.planes &= ~PLANES_LENS_SURFACE, plan.lens_relight = 0, plan.paths.spp = 9),
           ERR_RANGE, "paths.spp");
    EXPECT((plan.planes &= ~PLANES_LENS, plan.lens_strata_per_axis = plan.lens_relight = 0), ERR_OK,
           "");
    EXPECT(plan.camera.aperture_radius = 0, ERR_RANGE, "planes");
    EXPECT(plan.lens_filter = LENS_FILTER_AXIS_ALIGNED, ERR_OK, "");
    EXPECT(plan.lens_filter = LENS_FILTER_SHEARED, ERR_OK, "");
    EXPECT(plan.lens_filter = LENS_FILTER_SHEARED + 1, ERR_RANGE, "lens_filter");
    EXPECT((plan.lens_filter = LENS_FILTER_SHEARED, plan.planes &= ~slope), ERR_RANGE, "planes");
    EXPECT((plan.target_error = 1, plan.spp_max = 256,
            plan.planes &= ~(PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_STRATA))),
           ERR_RANGE, "target_error");
}

#define LOBES                                                                                      \
    plan.planes |= PLANE_BIT(LENS_LOBE), plan.lens_relight = LENS_RELIGHT_INDIRECT,                \
                                         plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT

/* Light fields that light lens samples are there, and all that these tell of their surfaces. */
TEST(light_of_lens_samples_is_checked)
{
    const uint64_t surface = PLANES_LENS_SURFACE;
    EXPECT(plan.lens_relight = LENS_RELIGHT_SKY + 1, ERR_RANGE, "lens_relight");
    EXPECT((plan.lens_relight = LENS_RELIGHT_SKY, plan.environment.kind = ENVIRONMENT_CONSTANT),
           ERR_OK, "");
    EXPECT((plan.lens_relight = LENS_RELIGHT_SKY,
            plan.environment = (struct plan_environment){.kind = ENVIRONMENT_NONE}),
           ERR_RANGE, "lens_relight");
    EXPECT(plan.lens_relight = LENS_RELIGHT_INDIRECT, ERR_OK, "");
    EXPECT((plan.lens_relight = LENS_RELIGHT_OWN, plan.paths.spp = 4), ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~surface, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~PLANE_BIT(LENS_OWN_LIGHT), ERR_RANGE, "planes");
    EXPECT((plan.lens_relight = LENS_RELIGHT_OWN, plan.paths.spp = 4, plan.planes &= ~surface),
           ERR_OK, "");
    EXPECT((LOBES), ERR_OK, "");
    EXPECT((LOBES, plan.lens_relight = LENS_RELIGHT_DIFFUSE), ERR_RANGE, "planes");
    EXPECT((LOBES, plan.glossy_filter = GLOSSY_FILTER_NONE), ERR_RANGE, "planes");
    EXPECT(
        (LOBES, plan.lens_relight = LENS_RELIGHT_OWN, plan.paths.spp = 4, plan.planes &= ~surface),
        ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~PLANE_BIT(NORMAL), ERR_RANGE, "planes");
    EXPECT((plan.lens_relight = LENS_RELIGHT_INDIRECT, plan.indirect_strata_per_axis = 0,
            plan.planes &= ~(PLANES_BOUNCE_RAYS | PLANES_GLOSSY), plan.bounces = 0,
            plan.occlusion_distance = 0, plan.planes &= ~PLANE_BIT(PATH_VISIBILITY)),
           ERR_RANGE, "planes");
}

/* Mirrors are looked through where fields light what they show; each is a scattering. */
TEST(mirrors_are_checked)
{
    EXPECT((plan.lens_relight = LENS_RELIGHT_INDIRECT, plan.lens_mirrors = 1), ERR_OK, "");
    EXPECT((plan.lens_relight = LENS_RELIGHT_INDIRECT, plan.lens_mirrors = 2), ERR_LIMIT,
           "lens_mirrors");
    EXPECT((plan.lens_relight = LENS_RELIGHT_INDIRECT, plan.bounces = 9, plan.lens_mirrors = 4),
           ERR_OK, "");
    EXPECT((plan.lens_relight = LENS_RELIGHT_INDIRECT, plan.bounces = 9, plan.lens_mirrors = 5),
           ERR_LIMIT, "lens_mirrors");
    EXPECT(plan.lens_mirrors = 1, ERR_LIMIT, "lens_mirrors");
    EXPECT((plan.lens_relight = LENS_RELIGHT_INDIRECT, plan.lens_mirrors = 1,
            plan.indirect_filter = INDIRECT_FILTER_SHEARED),
           ERR_LIMIT, "lens_mirrors");
    EXPECT((LOBES, plan.lens_lobes_only = 1), ERR_OK, "");
    EXPECT((LOBES, plan.lens_lobes_only = 2), ERR_LIMIT, "lens_lobes_only");
    EXPECT(plan.lens_lobes_only = 1, ERR_LIMIT, "lens_lobes_only");
}

#define EXTRA                                                                                      \
    (plan.lens_extra = 9, plan.lens_filter = LENS_FILTER_SHEARED,                                  \
     plan.planes |= PLANE_BIT(LENS_SECOND_SET))

/* Second sets through the lens belong to its sheared filter, and have their plane. */
TEST(lens_extra_is_checked)
{
    EXPECT(EXTRA, ERR_OK, "");
    EXPECT((EXTRA, plan.lens_extra = 36), ERR_OK, "");
    EXPECT((EXTRA, plan.lens_extra = 37), ERR_LIMIT, "lens_extra");
    EXPECT((EXTRA, plan.lens_extra = 0), ERR_RANGE, "planes");
    EXPECT((EXTRA, plan.planes &= ~PLANE_BIT(LENS_SECOND_SET)), ERR_RANGE, "planes");
    EXPECT((EXTRA, plan.lens_filter = LENS_FILTER_AXIS_ALIGNED), ERR_RANGE, "lens_extra");
    EXPECT((EXTRA, ADAPTIVE), ERR_RANGE, "lens_extra");
}

TEST(second_sets_through_the_lens_are_checked)
{
    static struct plan plan;
    static const uint8_t strata_map[] = {0, 6, 0, 6};
    plan_case(&plan);
    EXTRA;
    const uint32_t last = plan_pass_count(&plan);
    struct plan_pass pass = {
        .number = last, .strata = PLAN_LENS_EXTRA_STRATA, .strata_map = strata_map};
    assert_true(plan_has_rounds(&plan));
    assert_int_equal(plan_strata_maps(&plan), 1); /* though it asks how far lobes see */
    assert_true(plan_pass_planes(&plan, last) == PLANES_LENS_SECOND_SET);
    assert_int_equal(plan_pass_check(&plan, &pass), 0);
    assert_int_equal(plan_strata_map_check(&pass, 4), 0);
    pass.lobes = strata_map;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass.lobes = NULL;
    pass.strata = 5;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass.strata = 7;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass = (struct plan_pass){
        .number = last + 1, .strata = PLAN_LENS_EXTRA_STRATA, .strata_map = strata_map};
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass = (struct plan_pass){.number = last, .strata = PLAN_LENS_EXTRA_STRATA};
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
}
