/* The planes of a plan, and how many samples they hold: what paths and lone sub-samples need of
 * them, and which ones lights have. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

TEST(paths_are_checked)
{
    const uint64_t spread = PLANE_BIT(PATH_M2), radiance = PLANE_BIT(PATH_RADIANCE),
                   open = PLANE_BIT(PATH_VISIBILITY) | PLANE_BIT(AMBIENT_VISIBILITY);
    EXPECT(plan.paths.spp = LIMIT_SPP, ERR_OK, "");
    EXPECT(plan.paths.spp = LIMIT_SPP + 1, ERR_LIMIT, "paths.spp");
    EXPECT(plan.occlusion_distance = -1, ERR_RANGE, "occlusion_distance");
    EXPECT(plan.occlusion_distance = NAN, ERR_NOT_FINITE, "occlusion_distance");
    EXPECT(plan.paths.pixel_filter = PIXEL_FILTER_TENT + 1, ERR_LIMIT, "paths.pixel_filter");
    EXPECT(plan.paths.emitter_power = -1, ERR_RANGE, "paths.emitter_power");
    EXPECT(plan.paths.emitter_power = INFINITY, ERR_NOT_FINITE, "paths.emitter_power");
    EXPECT(plan.paths.emitter_power = 0, ERR_OK, "");
    EXPECT(plan.paths.spp = 0, ERR_RANGE, "planes");
    EXPECT((plan.paths = (struct plan_paths){0}, plan.planes &= ~PLANES_PATH_ALL), ERR_OK, "");
    EXPECT((plan.occlusion_distance = 0, plan.planes &= ~PLANES_PATH_ALL), ERR_RANGE, "planes");
    EXPECT(plan.paths.without_diffuse_indirect = 1, ERR_OK, "");
    EXPECT(plan.paths.without_diffuse_indirect = 3, ERR_LIMIT, "paths.without_diffuse_indirect");
    EXPECT((plan.paths.without_diffuse_indirect = INDIRECT_LEFT_SKY,
            plan.environment.kind = ENVIRONMENT_NONE),
           ERR_RANGE, "paths.without_diffuse_indirect");
    EXPECT((plan.paths.without_diffuse_indirect = INDIRECT_LEFT_SKY,
            plan.environment.kind = ENVIRONMENT_CONSTANT),
           ERR_OK, "");
    EXPECT((plan.paths.without_diffuse_indirect = 1, plan.planes = PLANES_PATH), ERR_RANGE,
           "planes");
    EXPECT(plan.occlusion_distance = 0, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~open, ERR_RANGE, "planes");
    EXPECT((plan.planes &= ~open, plan.occlusion_distance = 0), ERR_OK, "");
    EXPECT(plan.planes &= ~radiance, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~(radiance | spread), ERR_OK, "");
    EXPECT(plan.planes &= ~spread, ERR_OK, "");
}

/* Fields bring what paths leave out of direct light: from pixel centres, through a box. */
static void leave(struct plan *plan, uint32_t direct)
{
    without_lens(plan);
    plan->paths.pixel_filter = PIXEL_FILTER_BOX;
    plan->paths.without_diffuse_direct = direct;
}

TEST(direct_light_is_left_to_fields)
{
    static const char place[] = "paths.without_diffuse_direct";
    EXPECT(leave(&plan, DIRECT_LEFT_LISTED), ERR_OK, "");
    EXPECT(leave(&plan, DIRECT_LEFT_LISTED + 1), ERR_LIMIT, place);
    EXPECT((leave(&plan, DIRECT_LEFT_LISTED), plan.paths.without_diffuse_indirect = 1), ERR_OK, "");
    EXPECT((leave(&plan, DIRECT_LEFT_LISTED),
            plan.paths.without_diffuse_indirect = plan.paths.without_glossy_indirect = 1),
           ERR_LIMIT, place);
    EXPECT((leave(&plan, DIRECT_LEFT_LISTED), plan.paths.pixel_filter = PIXEL_FILTER_TENT),
           ERR_LIMIT, place);
    EXPECT(plan.paths.without_diffuse_direct = DIRECT_LEFT_LISTED, ERR_LIMIT, place);
    EXPECT((leave(&plan, DIRECT_LEFT_ALL), plan.paths.without_diffuse_indirect = 1), ERR_LIMIT,
           place);
    EXPECT((leave(&plan, DIRECT_LEFT_ALL), plan.environment = (struct plan_environment){0}),
           ERR_LIMIT, place);
    EXPECT((leave(&plan, DIRECT_LEFT_ALL), plan.environment = (struct plan_environment){0},
            plan.paths.without_diffuse_indirect = 1),
           ERR_OK, "");
}

/* Paths need nothing of the light field. */
TEST(paths_stand_alone)
{
    EXPECT((plan.planes = PLANES_PATH, plan.light_planes = 0, plan.sub_samples = 0,
            plan.indirect_strata_per_axis = plan.lens_strata_per_axis = plan.lens_relight = 0,
            plan.bounces = LIMIT_INDIRECT_BOUNCES),
           ERR_OK, "");
    EXPECT((plan.planes = PLANES_PATH,
            plan.indirect_strata_per_axis = plan.lens_strata_per_axis = plan.lens_relight = 0,
            plan.bounces = 0),
           ERR_OK, "");
    EXPECT((plan.planes = PLANES_PATH, plan.light_planes = 1u << LIGHT_PLANE_SLOPES,
            plan.indirect_strata_per_axis = 1, plan.lens_strata_per_axis = plan.lens_relight = 0),
           ERR_LIMIT, "indirect_strata_per_axis");
}

TEST(planes_and_counts_are_checked)
{
    EXPECT(plan.planes |= PLANE_BIT(ID_COUNT), ERR_RANGE, "planes");
    EXPECT(plan.light_planes |= 1u << LIGHT_PLANE_COUNT, ERR_RANGE, "light_planes");
    EXPECT(plan.capabilities = 1u << 31, ERR_RANGE, "capabilities");
    EXPECT(plan.sub_samples = 4, ERR_LIMIT, "sub_samples");
    EXPECT(plan.sub_samples = 0, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~PLANE_BIT(DEPTH), ERR_RANGE, "planes");
    EXPECT((plan.bounces = 0, plan.indirect_strata_per_axis = 0), ERR_RANGE, "planes");
    EXPECT(plan.bounces = LIMIT_INDIRECT_BOUNCES + 1, ERR_LIMIT, "bounces");
    EXPECT(plan.indirect_strata_per_axis = 0, ERR_RANGE, "indirect_strata_per_axis");
    EXPECT(plan.indirect_strata_per_axis = 17, ERR_LIMIT, "indirect_strata_per_axis");
    EXPECT((plan.indirect_strata_per_axis = 256, plan.planes &= ~PLANE_BIT(INDIRECT_STRATA)),
           ERR_OK, "");
    EXPECT((plan.bounces = 0, plan.planes = 1, plan.paths = (struct plan_paths){0},
            plan.occlusion_distance = 0, plan.lens_strata_per_axis = plan.lens_relight = 0),
           ERR_LIMIT, "indirect_strata_per_axis");
    EXPECT((plan.planes = 0, plan.occlusion_distance = 0, plan.light_planes = 0,
            plan.sub_samples = 0, plan.indirect_strata_per_axis = 0,
            plan.lens_strata_per_axis = plan.lens_relight = 0, plan.paths = (struct plan_paths){0}),
           ERR_OK, "");
    EXPECT(plan.radiance_scale = 0.3f, ERR_RANGE, "radiance_scale");
    EXPECT(plan.radiance_scale = 0, ERR_RANGE, "radiance_scale");
    EXPECT(plan.radiance_scale = -1, ERR_RANGE, "radiance_scale");
    EXPECT(plan.length_unit = 3, ERR_RANGE, "length_unit");
    EXPECT(plan.length_unit = NAN, ERR_NOT_FINITE, "length_unit");
}

/* Lone sub-samples are for pinholes. */
static void lone_case(struct plan *plan)
{
    plan->paths = (struct plan_paths){0};
    plan->camera.aperture_radius = 0.0f;
    plan->lens_strata_per_axis = plan->lens_relight = 0;
    plan->planes = (plan->planes & ~(PLANES_PATH_ALL | PLANES_LENS_ALL)) | PLANE_BIT(LONE);
    plan->occlusion_distance = 1.0f;
}

TEST(lone_sub_samples_are_checked)
{
    static const int compared[] = {PLANE_DEPTH,      PLANE_NORMAL,     PLANE_ID,    PLANE_SUB_DEPTH,
                                   PLANE_SUB_NORMAL, PLANE_SUB_ALBEDO, PLANE_SUB_ID};
    EXPECT(lone_case(&plan), ERR_OK, "");
    for (size_t i = 0; i < sizeof compared / sizeof compared[0]; i++)
        EXPECT((lone_case(&plan), plan.planes &= ~(UINT64_C(1) << compared[i])), ERR_RANGE,
               "planes");
    EXPECT((lone_case(&plan), plan.camera.aperture_radius = 0.1f), ERR_RANGE, "planes");
    EXPECT((lone_case(&plan), plan.tile_px = 36), ERR_RANGE, "tile_px");
    EXPECT((lone_case(&plan), plan.tile_px = 40), ERR_OK, "");
    EXPECT((lone_case(&plan), plan.planes |= UINT64_C(1) << 61), ERR_RANGE, "planes");
    /* Nothing would light them. */
    EXPECT((lone_case(&plan), plan.planes &= ~(PLANES_BOUNCE_LIGHT | PLANES_GLOSSY),
            plan.light_planes = 0),
           ERR_RANGE, "planes");
    EXPECT((lone_case(&plan), plan.planes &= ~(PLANES_BOUNCE_LIGHT | PLANES_GLOSSY)), ERR_OK, "");
}

TEST(mixed_pixels_are_checked)
{
    EXPECT((lone_case(&plan), plan.planes |= PLANE_BIT(MIXED)), ERR_OK, "");
    EXPECT((lone_case(&plan), plan.planes ^= PLANE_BIT(LONE) | PLANE_BIT(MIXED)), ERR_OK, "");
    EXPECT((lone_case(&plan), plan.planes ^= PLANE_BIT(LONE) | PLANE_BIT(MIXED),
            plan.planes &= ~PLANE_BIT(SUB_ID)),
           ERR_RANGE, "planes");
    EXPECT((lone_case(&plan), plan.planes ^= PLANE_BIT(LONE) | PLANE_BIT(MIXED),
            plan.camera.aperture_radius = 0.1f),
           ERR_RANGE, "planes");
}

static void paths_case(struct plan *plan)
{
    plan->camera.aperture_radius = 0.0f;
    plan->lens_strata_per_axis = plan->lens_relight = plan->sub_samples = 0;
    plan->indirect_strata_per_axis = 0;
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) | PLANE_BIT(PATH_RADIANCE) |
                   PLANE_BIT(MIXED);
    plan->light_planes = 0;
    plan->occlusion_distance = 0.0f;
}

/* Under paths, centres find mixed pixels. */
TEST(mixed_pixels_of_paths_need_centres)
{
    static const int centre[] = {PLANE_DEPTH, PLANE_NORMAL, PLANE_ID};
    EXPECT(paths_case(&plan), ERR_OK, "");
    for (size_t i = 0; i < sizeof centre / sizeof centre[0]; i++)
        EXPECT((paths_case(&plan), plan.planes &= ~(UINT64_C(1) << centre[i])), ERR_RANGE,
               "planes");
    EXPECT((paths_case(&plan), plan.camera.aperture_radius = 0.1f), ERR_RANGE, "planes");
}

TEST(light_planes_follow_the_type)
{
    static struct plan plan;
    plan_case(&plan);
    for (uint32_t filter = 0; filter <= SHADOW_FILTER_SHEARED; filter++) {
        plan.shadow_filter = filter;
        for (uint32_t k = 0; k < 3; k++)
            assert_int_equal(plan_light_planes(&plan, k), 1u << LIGHT_PLANE_IRRADIANCE);
        assert_int_equal(plan_light_planes(&plan, 3),
                         filter ? PLAN_CASE_LIGHT_PLANES & ~(1u << LIGHT_PLANE_IRRADIANCE)
                                : PLAN_CASE_LIGHT_PLANES);
    }
    plan.light_planes = 1u << LIGHT_PLANE_SLOPES;
    assert_int_equal(plan_light_planes(&plan, 0), 0);
}
