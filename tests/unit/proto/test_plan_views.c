/* Plans with views: their passes, and what such plans may have. */
#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

static struct plan composite_plan(uint32_t spp)
{
    static struct plan plan;
    plan_case(&plan);
    plan.planes &= PLANES_PATH_ALL;
    plan.light_planes = plan.sub_samples = plan.indirect_strata_per_axis = 0;
    plan.lens_strata_per_axis = plan.lens_relight = plan.lens_mirrors = 0;
    plan.shadow_filter = plan.indirect_filter = plan.glossy_filter = plan.lens_filter = 0;
    plan.target_error = 0;
    plan.spp_max = plan.lens_extra = 0;
    for (uint32_t k = 0; k < plan.light_count; k++) plan.lights[k].strata_per_axis = 1;
    plan.paths.spp = spp;
    plan.composite = 1;
    return plan;
}

TEST(each_pass_is_traced_once_for_each_view)
{
    for (uint32_t spp = 1; spp <= 400; spp += 57) {
        const struct plan plan = composite_plan(spp), one = plan_of_view(&plan);
        const uint32_t count = plan_pass_count(&plan);
        assert_int_equal(plan_views(&one), 1);
        assert_int_equal(count, PLAN_VIEWS * plan_pass_count(&one));
        for (uint32_t number = 0; number < count; number++) {
            const struct plan_pass pass = plan_scheduled_pass(&plan, number),
                                   own = plan_scheduled_pass(&one, number / PLAN_VIEWS);
            assert_int_equal(pass.number, number);
            assert_int_equal(pass.first, own.first);
            assert_int_equal(pass.count, own.count);
            assert_int_equal(pass.strata, own.strata);
            assert_int_equal(plan_pass_planes(&plan, number), plan_pass_planes(&one, own.number));
            assert_int_equal(plan_pass_check(&plan, &pass), 0);
        }
        struct plan_pass beyond = plan_scheduled_pass(&plan, count - 1);
        beyond.number = count;
        assert_int_equal(plan_pass_check(&plan, &beyond), ERR_RANGE);
    }
}

#define REFUSES(change, code, place)                                                               \
    do {                                                                                           \
        struct fault fault = {0};                                                                  \
        struct plan plan = composite_plan(16);                                                     \
        change;                                                                                    \
        assert_int_equal(plan_check(&plan, &fault), code);                                         \
        assert_string_equal(fault.pointer, place);                                                 \
    } while (0)

static void show(struct plan *plan, enum photograph_fit fit)
{
    plan->photograph.fit = fit;
    plan->photograph.blob.bytes[0] = 1;
}

TEST(views_are_of_paths_alone)
{
    REFUSES((void)0, 0, "");
    REFUSES(plan.paths.spp = LIMIT_COMPOSITE_SPP, 0, "");
    REFUSES(plan.paths.spp = LIMIT_COMPOSITE_SPP + 1, ERR_LIMIT, "paths.spp");
    REFUSES(plan.composite = 2, ERR_LIMIT, "composite");
    REFUSES(show(&plan, PHOTOGRAPH_COVERS), 0, "");
    REFUSES(plan.photograph.fit = PHOTOGRAPH_COVERS, ERR_RANGE, "photograph.fit");
    REFUSES(show(&plan, PHOTOGRAPH_NONE), ERR_RANGE, "photograph.fit");
    REFUSES(plan.photograph.is_linear = 1, ERR_LIMIT, "photograph.is_linear");
    REFUSES(plan.photograph.fit = PHOTOGRAPH_COVERS + 1, ERR_RANGE, "photograph.fit");
    REFUSES(plan.photograph.is_linear = 2, ERR_LIMIT, "photograph.is_linear");
    REFUSES((plan.composite = 0, show(&plan, PHOTOGRAPH_COVERS)), ERR_LIMIT, "photograph.fit");
    REFUSES((plan.target_error = 0.1f, plan.spp_max = 100), ERR_LIMIT, "composite");
}

TEST(the_most_samples_fit_the_passes_of_a_frame)
{
    const struct plan plan = composite_plan(LIMIT_COMPOSITE_SPP);
    assert_true(plan_pass_count(&plan) <= LIMIT_PASSES);
}
