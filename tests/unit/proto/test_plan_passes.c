/* The passes of a plan: those of its schedule cover all samples once, and those that follow, for a
 * target of error or as second sets, are checked. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

/* The second set follows the schedule, once, with a strata map. */
TEST(second_sets_are_checked)
{
    static struct plan plan;
    static const uint8_t strata_map[] = {0, 3, 9, 1};
    plan_case(&plan);
    ADAPTIVE;
    plan.planes &= ~PLANE_BIT(GLOSSY_SPAN);
    const uint32_t last = plan_pass_count(&plan);
    struct plan_pass pass;
    assert_true(plan_has_rounds(&plan));
    assert_int_equal(plan_strata_maps(&plan), 1);
    assert_int_equal(plan_pass_planes(&plan, last),
                     PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(AMBIENT_VISIBILITY));
#define SECOND(change, code)                                                                       \
    do {                                                                                           \
        pass = (struct plan_pass){.number = last, .strata = 9, .strata_map = strata_map};          \
        change;                                                                                    \
        assert_int_equal(plan_pass_check(&plan, &pass), code);                                     \
    } while (0)
    SECOND((void)0, 0);
    SECOND(pass.strata = 1, 0);
    SECOND(pass.strata = 0, ERR_RANGE);
    SECOND(pass.strata = 10, ERR_LIMIT); /* 9 + 100 rays are above 100 */
    SECOND(pass.number = last + 1, ERR_RANGE);
    SECOND(pass.number = last - 1, ERR_RANGE);
    SECOND(pass.number = LIMIT_PASSES, ERR_LIMIT);
    SECOND(pass.count = 1, ERR_RANGE);
    SECOND(pass.first = 1, ERR_RANGE);
    SECOND(pass.strata_map = NULL, ERR_RANGE);
    SECOND(pass.lobes = strata_map, ERR_RANGE); /* the plan does not ask how far they see */
    plan.adaptive.rays_max = LIMIT_SPP;
    SECOND(pass.strata = PLAN_STRATA_MAX, 0);
    SECOND(pass.strata = PLAN_STRATA_MAX + 1, ERR_LIMIT);
    SECOND(pass.strata = UINT32_MAX, ERR_LIMIT);
    SECOND((void)0, 0);
    assert_int_equal(plan_strata_map_check(&pass, 4), 0);
    assert_int_equal(plan_strata_map_check(&pass, 2), ERR_RANGE); /* none of them is the largest */
    pass.strata = 8;
    assert_int_equal(plan_strata_map_check(&pass, 4), ERR_RANGE); /* one of them is above it */
    struct plan_pass first = plan_scheduled_pass(&plan, 0);
    assert_int_equal(plan_pass_check(&plan, &first), 0);
    first.strata_map = strata_map;
    assert_int_equal(plan_pass_check(&plan, &first), ERR_RANGE);
    first.strata_map = NULL;
    first.lobes = strata_map;
    assert_int_equal(plan_pass_check(&plan, &first), ERR_RANGE);
    plan.indirect_filter = INDIRECT_FILTER_LINEAR;
    SECOND((void)0, ERR_RANGE);
    assert_int_equal(plan_strata_maps(&plan), 0);
    assert_false(plan_has_rounds(&plan));
#undef SECOND
}

/* Where the plan asks how far glossy lobes see, they have second sets, too. */
TEST(second_sets_of_lobes_are_checked)
{
    static struct plan plan;
    static const uint8_t few[] = {0, 3, 1, 2}, many[] = {9, 0, 0, 1};
    plan_case(&plan);
    assert_int_equal(plan_strata_maps(&plan), 0);
    ADAPTIVE;
    const uint32_t last = plan_pass_count(&plan);
    assert_int_equal(plan_strata_maps(&plan), 2);
    assert_int_equal(plan_pass_planes(&plan, last), PLANE_BIT(INDIRECT_MEAN) |
                                                        PLANE_BIT(AMBIENT_VISIBILITY) |
                                                        PLANE_BIT(GLOSSY_MEAN));
    struct plan_pass pass = {.number = last, .strata = 9, .strata_map = few, .lobes = many};
    assert_int_equal(plan_pass_check(&plan, &pass), 0);
    assert_int_equal(plan_strata_map_check(&pass, 4), 0);
    pass.strata_map = many;
    pass.lobes = few;
    assert_int_equal(plan_strata_map_check(&pass, 4), 0);
    pass.strata_map = few;
    assert_int_equal(plan_strata_map_check(&pass, 4), ERR_RANGE); /* none of them is the largest */
    pass.lobes = many;
    pass.strata = 8;
    assert_int_equal(plan_strata_map_check(&pass, 4), ERR_RANGE); /* one of them is above it */
    pass.lobes = NULL;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
}

TEST(passes_cover_all_samples_once)
{
    static const uint32_t lengths[] = {16, 16, 32};
    static struct plan plan;
    plan_case(&plan);
    for (uint32_t spp = 1; spp <= LIMIT_SPP; spp += spp < 2000 ? 1 : 997) {
        uint32_t first, count, sum = 0;
        plan.paths.spp = spp;
        const uint32_t passes = plan_pass_count(&plan);
        assert_in_range(passes, 1, LIMIT_PASSES);
        for (uint32_t p = 0; p < passes; p++) {
            plan_pass_range(&plan, p, &first, &count);
            const uint32_t full = p < 3 ? lengths[p] : LIMIT_PASS_SPP;
            assert_int_equal(first, sum);
            assert_int_equal(plan_pass_spp(&plan, p), sum);
            assert_int_equal(count, p + 1 < passes || full < spp - sum ? full : spp - sum);
            sum += count;
        }
        assert_int_equal(sum, spp);
        assert_int_equal(plan_pass_spp(&plan, passes), spp);
        plan_pass_range(&plan, passes, &first, &count);
        assert_true(first == spp && count == 0);
    }
}

TEST(passes_are_bounded)
{
    static struct plan plan;
    uint32_t first, count;
    plan_case(&plan);
    plan.paths.spp = LIMIT_SPP;
    assert_int_equal(plan_pass_count(&plan), LIMIT_PASSES);
    plan_pass_range(&plan, UINT32_MAX - 1, &first, &count);
    assert_true(first == LIMIT_SPP && count == 0);
    plan.paths.spp = 0;
    assert_int_equal(plan_pass_count(&plan), 1);
    assert_int_equal(plan_pass_spp(&plan, 1), 0);
    plan_pass_range(&plan, 0, &first, &count);
    assert_true(first == 0 && count == 0);
}

TEST(passes_after_the_schedule_are_checked)
{
    static struct plan plan;
    plan_case(&plan);
    plan.paths.spp = 16;
    for (uint32_t p = 0; p < 2; p++) {
        const struct plan_pass pass = plan_scheduled_pass(&plan, p);
        assert_int_equal(plan_pass_check(&plan, &pass), p == 0 ? 0 : ERR_RANGE);
    }
    struct plan_pass pass = {1, 16, 48, 4, NULL, NULL};
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE); /* no target */
    plan.target_error = 0.1f;
#define PASS(change, code)                                                                         \
    do {                                                                                           \
        pass = (struct plan_pass){1, 16, 48, 4, NULL, NULL};                                       \
        change;                                                                                    \
        assert_int_equal(plan_pass_check(&plan, &pass), code);                                     \
    } while (0)
    PASS((void)0, 0);
    PASS(pass.number = LIMIT_PASSES - 1, 0);
    PASS(pass.number = LIMIT_PASSES, ERR_LIMIT);
    PASS(pass.number = 0, ERR_RANGE); /* that is the schedule's */
    PASS(pass.strata = 0, 0);
    PASS(pass.strata = 3, ERR_RANGE);
    PASS(pass.strata = 8, 0);
    PASS(pass.strata = 10, ERR_LIMIT);
    PASS(pass.strata = 0x10000, ERR_LIMIT); /* whose square is 0 in 32 bits */
    PASS(pass.count = 0, 0);
    PASS((pass.count = 0, pass.strata = 0), ERR_RANGE);
    PASS(pass.count = LIMIT_PASS_SPP + 1, ERR_LIMIT);
    PASS(pass.first = LIMIT_SPP - 48, 0);
    PASS(pass.first = LIMIT_SPP - 47, ERR_LIMIT);
    PASS(pass.first = UINT32_MAX, ERR_LIMIT);
    plan.indirect_strata_per_axis = 0;
    PASS((void)0, ERR_RANGE);
    PASS(pass.strata = 0, 0);
    plan.paths.spp = 0;
    PASS(pass.strata = 0, ERR_RANGE);
#undef PASS
}

TEST(passes_are_split_where_the_sequence_is)
{
    static const struct {
        uint32_t first, count;
        struct plan_split split;
    } cases[] = {
        {0, 0, {0, 0, 0}},     {0, 1, {0, 0, 0}},    {3, 2, {0, 0, 0}},
        {0, 2, {0, 2, 1}},     {0, 9, {0, 8, 1}},    {16, 16, {16, 16, 1}},
        {32, 32, {32, 32, 1}}, {9, 31, {16, 16, 1}}, {16, 48, {32, 32, 1}},
        {8, 24, {16, 16, 1}},  {40, 16, {40, 8, 2}}, {65472, 64, {65472, 64, 1}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const struct plan_pass pass = {0, cases[k].first, cases[k].count, 0, NULL, NULL};
        const struct plan_split split = plan_pass_split(&pass);
        assert_memory_equal(&split, &cases[k].split, sizeof split);
    }
}

TEST(targets_are_checked)
{
    const uint64_t other = PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_STRATA) | PLANES_GLOSSY;
#define TARGET(change, code, place)                                                                \
    EXPECT((plan.target_error = 0.02f, plan.spp_max = 256, plan.planes &= ~other,                  \
            without_lens(&plan), change),                                                          \
           code, place)
    TARGET(plan.spp_max = LIMIT_SPP, ERR_OK, "");
    TARGET(plan.spp_max = LIMIT_SPP + 1, ERR_LIMIT, "spp_max");
    TARGET(plan.spp_max = 0, ERR_RANGE, "spp_max");
    TARGET(plan.target_error = 0, ERR_RANGE, "spp_max");
    TARGET(plan.target_error = -1, ERR_RANGE, "target_error");
    TARGET(plan.target_error = NAN, ERR_NOT_FINITE, "target_error");
    TARGET(plan.planes &= ~PLANE_BIT(PATH_M2), ERR_RANGE, "target_error");
    TARGET(plan.planes &= ~PLANE_BIT(PATH_HALF_DIFFERENCE2), ERR_RANGE, "target_error");
    TARGET(plan.planes |= PLANE_BIT(INDIRECT_MEAN), ERR_RANGE, "target_error");
    TARGET(plan.planes |= PLANES_GLOSSY, ERR_OK, "");
    TARGET(plan.planes |= PLANES_GLOSSY & ~PLANE_BIT(GLOSSY_HALF), ERR_RANGE, "target_error");
    TARGET(plan.planes |= PLANES_GLOSSY & ~PLANE_BIT(GLOSSY_MEAN), ERR_RANGE, "planes");
    TARGET(plan.planes &= ~PLANE_BIT(BOUNCE_DISTANCE_MIN), ERR_RANGE, "target_error");
#undef TARGET
}
