/* The filters of a plan: of shadows, indirect light and glossy lobes. They need their planes. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

/* Filters of glossy lobes need their planes; paths leave out what planes bring. */
TEST(glossy_filters_are_checked)
{
    const uint64_t lobe = PLANE_BIT(GLOSSY_LOBE), near = PLANE_BIT(GLOSSY_NEARNESS);
    const uint64_t light = PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) |
                           PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(BOUNCE_DISTANCE_MIN) |
                           PLANE_BIT(AMBIENT_VISIBILITY);
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_BANDLIMIT, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_SG, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_SG_MIXTURE, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_ASG, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_LAST + 1, ERR_RANGE, "glossy_filter");
    EXPECT((plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT, plan.planes &= ~near), ERR_RANGE,
           "planes");
    EXPECT((plan.glossy_filter = GLOSSY_FILTER_BANDLIMIT, plan.planes &= ~PLANE_BIT(ID)), ERR_RANGE,
           "planes");
    EXPECT((plan.glossy_filter = GLOSSY_FILTER_ASG, plan.planes &= ~near), ERR_RANGE, "planes");
    EXPECT(plan.paths.without_glossy_indirect = 1, ERR_LIMIT, "paths.without_glossy_indirect");
    EXPECT((plan.paths.without_diffuse_indirect = plan.paths.without_glossy_indirect = 1), ERR_OK,
           "");
    EXPECT((plan.paths.without_diffuse_indirect = plan.paths.without_glossy_indirect = 1,
            plan.planes &= ~lobe),
           ERR_RANGE, "planes");
    EXPECT((plan.planes &= ~light, plan.occlusion_distance = 0,
            plan.planes &= ~PLANE_BIT(PATH_VISIBILITY)),
           ERR_OK, "");
    EXPECT((plan.planes &= ~light, plan.occlusion_distance = 0,
            plan.planes &= ~PLANE_BIT(PATH_VISIBILITY), plan.indirect_strata_per_axis = 0),
           ERR_RANGE, "indirect_strata_per_axis");
}

/* Filters of indirect light need their planes, and planes their rays. */
TEST(indirect_filters_are_checked)
{
    const uint64_t bounce_distance_min = PLANE_BIT(BOUNCE_DISTANCE_MIN),
                   strata = PLANE_BIT(INDIRECT_STRATA);
    const uint64_t light = PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) | strata;
    EXPECT(plan.indirect_filter = INDIRECT_FILTER_CONSTANT, ERR_OK, "");
    EXPECT(plan.indirect_filter = INDIRECT_FILTER_SHEARED, ERR_OK, "");
    EXPECT(plan.indirect_filter = INDIRECT_FILTER_SHEARED + 1, ERR_RANGE, "indirect_filter");
    EXPECT((plan.indirect_filter = INDIRECT_FILTER_LINEAR, plan.planes &= ~bounce_distance_min),
           ERR_RANGE, "planes");
    EXPECT((plan.indirect_filter = INDIRECT_FILTER_SHEARED, plan.planes &= ~strata), ERR_RANGE,
           "planes");
    EXPECT((plan.indirect_filter = INDIRECT_FILTER_SHEARED, plan.planes &= ~bounce_distance_min),
           ERR_RANGE, "planes");
    EXPECT((plan.bounces = 0), ERR_RANGE, "planes");
    EXPECT((plan.bounces = 0, plan.planes &= ~(light | PLANES_GLOSSY)), ERR_OK,
           ""); /* occlusion alone */
    EXPECT((plan.bounces = 0, plan.planes &= ~light), ERR_RANGE, "planes");
}

/* Filters of one width take what pixels lend each other, where these have all of their rays at
 * once.
 */
#define HALVED                                                                                     \
    plan.field_halved = 1, plan.indirect_filter = INDIRECT_FILTER_CONSTANT,                        \
    plan.lens_relight = LENS_RELIGHT_OWN, plan.lens_strata_per_axis = 0,                           \
    plan.planes &= ~(PLANES_LENS_ALL | PLANE_BIT(INDIRECT_STRATA))
TEST(half_fields_are_checked)
{
    EXPECT((HALVED), ERR_OK, "");
    EXPECT((HALVED, plan.indirect_filter = INDIRECT_FILTER_LINEAR), ERR_OK, "");
    EXPECT((HALVED, plan.field_halved = 2), ERR_LIMIT, "field_halved");
    EXPECT((HALVED, plan.indirect_filter = INDIRECT_FILTER_NONE), ERR_RANGE, "field_halved");
    EXPECT((HALVED, plan.indirect_filter = INDIRECT_FILTER_BLEND), ERR_RANGE, "field_halved");
    EXPECT((HALVED, plan.planes |= PLANE_BIT(INDIRECT_STRATA)), ERR_RANGE, "field_halved");
    EXPECT((ADAPTIVE, plan.field_halved = 1), ERR_RANGE, "field_halved");
    EXPECT(plan.field_halved = 1, ERR_RANGE, "field_halved"); /* there is a lens */
}

/* Adaptive sampling belongs to one filter, which has means and distances and no target. */
TEST(rates_are_checked)
{
    EXPECT(ADAPTIVE, ERR_OK, "");
    EXPECT((ADAPTIVE, plan.indirect_filter = INDIRECT_FILTER_LINEAR), ERR_RANGE, "adaptive.mu");
    EXPECT((ADAPTIVE, plan.adaptive.mu = 0), ERR_RANGE, "adaptive.mu");
    EXPECT((ADAPTIVE, plan.adaptive.mu = -1), ERR_RANGE, "adaptive.mu");
    EXPECT((ADAPTIVE, plan.adaptive.mu = LIMIT_FILTER_MU), ERR_OK, "");
    EXPECT((ADAPTIVE, plan.adaptive.mu = LIMIT_FILTER_MU + 1), ERR_RANGE, "adaptive.mu");
    EXPECT((ADAPTIVE, plan.adaptive.mu = NAN), ERR_NOT_FINITE, "adaptive.mu");
    EXPECT((ADAPTIVE, plan.adaptive.rays_max = 0), ERR_RANGE, "adaptive.mu");
    EXPECT((ADAPTIVE, plan.adaptive.rays_max = 8), ERR_RANGE,
           "adaptive.rays_max"); /* the first are nine */
    EXPECT((ADAPTIVE, plan.adaptive.rays_max = 9), ERR_OK, "");
    EXPECT((ADAPTIVE, plan.adaptive.rays_max = LIMIT_SPP), ERR_OK, "");
    EXPECT((ADAPTIVE, plan.adaptive.rays_max = LIMIT_SPP + 1), ERR_LIMIT, "adaptive.rays_max");
    EXPECT((ADAPTIVE, plan.planes &= ~PLANE_BIT(BOUNCE_DISTANCE_MAX)), ERR_RANGE, "planes");
    EXPECT((ADAPTIVE, plan.planes &= ~PLANE_BIT(BOUNCE_DISTANCE_MIN)), ERR_RANGE, "planes");
    EXPECT((ADAPTIVE, plan.planes |= PLANE_BIT(INDIRECT_HALVES)), ERR_RANGE, "indirect_filter");
    EXPECT((ADAPTIVE, plan.planes |= PLANE_BIT(INDIRECT_STRATA)), ERR_RANGE, "indirect_filter");
    EXPECT((ADAPTIVE, plan.planes |= PLANE_BIT(GLOSSY_HALF)), ERR_RANGE, "indirect_filter");
    EXPECT((ADAPTIVE, plan.planes &= ~(PLANE_BIT(INDIRECT_MEAN) | PLANES_GLOSSY),
            plan.target_error = 0.1f, plan.spp_max = 200),
           ERR_RANGE, "indirect_filter");
    EXPECT((ADAPTIVE, plan.planes &= ~PLANE_BIT(INDIRECT_MEAN)), ERR_OK, ""); /* occlusion alone */
    EXPECT((ADAPTIVE, plan.planes &= ~PLANE_BIT(GLOSSY_NEARNESS), plan.glossy_filter = 0,
            plan.paths.without_glossy_indirect = 0),
           ERR_RANGE, "planes");
    EXPECT((ADAPTIVE, plan.planes &= ~PLANE_BIT(GLOSSY_SPAN)), ERR_OK, "");
}

/* A filtered plan: of light fields alone. */
static void filtered_case(struct plan *plan)
{
    plan->paths = (struct plan_paths){0};
    plan->planes &= ~PLANES_PATH_ALL;
    plan->shadow_filter = SHADOW_FILTER_SHEARED;
}

TEST(filters_are_checked)
{
    EXPECT(filtered_case(&plan), ERR_OK, "");
    EXPECT((filtered_case(&plan), plan.shadow_filter = SHADOW_FILTER_AXIS_ALIGNED), ERR_OK, "");
    EXPECT((filtered_case(&plan), plan.shadow_filter = 3), ERR_RANGE, "shadow_filter");
    EXPECT(plan.shadow_filter = SHADOW_FILTER_SHEARED, ERR_RANGE, "shadow_filter");
    EXPECT((filtered_case(&plan), plan.planes &= ~PLANE_BIT(NORMAL)), ERR_RANGE, "planes");
    EXPECT((filtered_case(&plan), plan.planes &= ~(PLANE_BIT(SUB_DEPTH) | PLANE_BIT(DEPTH))),
           ERR_RANGE, "planes");
    EXPECT((filtered_case(&plan), plan.light_planes &= ~(1u << LIGHT_PLANE_SLOPES)), ERR_RANGE,
           "light_planes");
    EXPECT((filtered_case(&plan), plan.light_planes &= ~(1u << LIGHT_PLANE_VISIBILITY)), ERR_RANGE,
           "light_planes");
    EXPECT((filtered_case(&plan), plan.light_planes &= ~(1u << LIGHT_PLANE_IRRADIANCE)), ERR_OK,
           "");
    EXPECT((filtered_case(&plan), plan.lights[3].strata_per_axis = 17), ERR_LIMIT,
           "lights[3].strata_per_axis");
    EXPECT(plan.mu = 0, ERR_RANGE, "mu");
    EXPECT(plan.mu = -1, ERR_RANGE, "mu");
    EXPECT(plan.mu = 100, ERR_OK, "");
    EXPECT(plan.mu = 100.5f, ERR_RANGE, "mu");
    EXPECT(plan.mu = NAN, ERR_NOT_FINITE, "mu");
    EXPECT(plan.mu = INFINITY, ERR_NOT_FINITE, "mu");
}

TEST(windows_of_frames_are_checked)
{
#define TEMPORAL(n)                                                                                \
    (without_lens(&plan), plan.residual_filter = RESIDUAL_FILTER_HALVES, plan.temporal = (n))
    EXPECT(TEMPORAL(LIMIT_TEMPORAL_FRAMES), ERR_OK, "");
    EXPECT(TEMPORAL(LIMIT_TEMPORAL_FRAMES + 1), ERR_LIMIT, "temporal");
    EXPECT(plan.temporal = 1, ERR_RANGE, "temporal");
    EXPECT((TEMPORAL(1), plan.planes &= ~PLANE_BIT(ID)), ERR_RANGE, "planes");
#undef TEMPORAL
}

/* The filter of paths needs all that it reads, and halves of whatever there are sums. */
TEST(residual_filters_are_checked)
{
    static const uint64_t read[] = {PLANE_BIT(PATH_RADIANCE),       PLANE_BIT(PATH_EMISSION),
                                    PLANE_BIT(PATH_DIFFUSE_DIRECT), PLANE_BIT(PATH_ALBEDO),
                                    PLANE_BIT(PATH_COVERAGE),       PLANE_BIT(PATH_HALF_SCATTERED),
                                    PLANE_BIT(PATH_HALF_DIRECT),    PLANE_BIT(PATH_NORMAL),
                                    PLANE_BIT(PATH_DISTANCE),       PLANE_BIT(PATH_TINT)};
    const uint64_t sum = PLANE_BIT(PATH_DIFFUSE_INDIRECT), half = PLANE_BIT(PATH_HALF_INDIRECT);
    EXPECT(plan.residual_filter = RESIDUAL_FILTER_HALVES, ERR_OK, "");
    EXPECT(plan.residual_filter = RESIDUAL_FILTER_OIDN + 1, ERR_RANGE, "residual_filter");
    for (size_t k = 0; k < sizeof read / sizeof *read; k++)
        EXPECT((plan.residual_filter = RESIDUAL_FILTER_HALVES, plan.planes &= ~read[k]), ERR_RANGE,
               "planes");
    EXPECT(plan.planes &= ~PLANES_RESIDUAL, ERR_OK, "");
    EXPECT((plan.residual_filter = RESIDUAL_FILTER_HALVES, plan.planes &= ~(sum | half)), ERR_OK,
           "");
    EXPECT((plan.residual_filter = RESIDUAL_FILTER_HALVES, plan.planes &= ~sum), ERR_RANGE,
           "planes");
    EXPECT((plan.residual_filter = RESIDUAL_FILTER_HALVES, plan.planes &= ~half), ERR_RANGE,
           "planes");
}

/* Open Image Denoise needs no halves, but one picture of paths whose error nobody asks for. */
TEST(frames_for_open_image_denoise_are_checked)
{
    static const uint64_t read[] = {PLANE_BIT(PATH_RADIANCE), PLANE_BIT(PATH_ALBEDO),
                                    PLANE_BIT(PATH_NORMAL)};
#define OIDN() (without_lens(&plan), plan.residual_filter = RESIDUAL_FILTER_OIDN)
    EXPECT(OIDN(), ERR_OK, "");
    EXPECT((OIDN(), plan.planes &= ~(PLANES_RESIDUAL & ~PLANE_BIT(PATH_NORMAL))), ERR_OK, "");
    for (size_t k = 0; k < sizeof read / sizeof *read; k++)
        EXPECT((OIDN(), plan.planes &= ~read[k]), ERR_RANGE, "planes");
    EXPECT(plan.residual_filter = RESIDUAL_FILTER_OIDN, ERR_RANGE, "residual_filter");
    EXPECT((OIDN(), plan.temporal = 1), ERR_RANGE, "temporal");
#undef OIDN
}
