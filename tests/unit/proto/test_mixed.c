/* Lists of mixed pixels: as they travel beside a tile's planes, and what is refused. */
#include <math.h>

#include "tests/unit/proto/list_case.h"

#define BIT(plane) PLANE_BIT(plane)

enum { PLACES = LIST_WIDTH * LIST_HEIGHT * MIXED_SLOTS };

static void fill(struct samples *s, uint32_t count)
{
    assert_int_equal(sparse_list_create(s->layout.mixed_values, count, &s->mixed), 0);
    for (uint32_t e = 0; e < count; e++) {
        s->mixed->words[e] = e * PLACES / count;
        for (uint32_t v = 0; v < s->mixed->values; v++)
            sparse_list_numbers(s->mixed, v)[e] = (float)((e * 31 + v * 7) % 64) / 63.0f;
    }
}

/* A plan with mixed pixels may have lone sub-samples, too. */
static struct list_case lists = {
    .name = "mixed", .planes = BIT(MIXED) | BIT(LONE), .places = PLACES, .fill = fill};

TEST(lists_round_trip)
{
    list_case_begin(&lists);
    list_case_round_trips(&lists);
    lists.plan.planes &= ~PLANES_GLOSSY; /* fewer values */
    list_case_round_trips(&lists);
}

TEST(lists_travel_beside_the_other_and_without_planes)
{
    list_case_begin(&lists);
    struct samples *s = list_case_create(&lists, 5);
    memset(s->data, 0, s->layout.total_bytes);
    list_case_round_trip(&lists, s);
    s = list_case_create(&lists, 5);
    assert_int_equal(lone_create(s->layout.lone_parts, 1, &s->lone), 0);
    list_case_round_trip(&lists, s);
}

TEST(samples_follow_the_plan)
{
    list_case_begin(&lists);
    lists.plan.light_count = 2;
    lists.plan.indirect_strata_per_axis = 2;
    lists.plan.lights[0].strata_per_axis = 1;
    lists.plan.lights[1].strata_per_axis = 3;
    assert_int_equal(mixed_samples(&lists.plan), 16);
    assert_int_equal(mixed_glow_samples(&lists.plan), 64);
    lists.plan.lights[1].strata_per_axis = 5;
    assert_int_equal(mixed_samples(&lists.plan), 32);
    assert_int_equal(mixed_glow_samples(&lists.plan), 64);
    lists.plan.indirect_strata_per_axis = 9;
    assert_int_equal(mixed_samples(&lists.plan), 96);
    assert_int_equal(mixed_glow_samples(&lists.plan), 96);
    lists.plan.paths.spp = 4; /* whatever layers there are besides */
    assert_int_equal(mixed_samples(&lists.plan), 16);
    lists.plan.paths.spp = 25;
    assert_int_equal(mixed_samples(&lists.plan), 64);
}

#define EXPECT(change, expected, place) LIST_EXPECT(&lists, change, expected, place)

TEST(hostile_entries_are_refused)
{
    EXPECT(s->mixed->words[8] = PLACES - 1, ERR_OK, "");
    EXPECT(s->mixed->words[8] = PLACES, ERR_RANGE, "mixed");
    EXPECT(s->mixed->words[8] = UINT32_MAX, ERR_RANGE, "mixed");
    EXPECT(s->mixed->words[4] = s->mixed->words[3], ERR_RANGE, "mixed");
    EXPECT(s->mixed->words[0] = s->mixed->words[1], ERR_RANGE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_SHARE)[2] = NAN, ERR_NOT_FINITE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_SHARE)[0] = 1.01f, ERR_RANGE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_ALBEDO + 2)[8] = INFINITY, ERR_NOT_FINITE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_REFLECTANCE + 2)[8] = -0.01f, ERR_RANGE, "mixed");
    EXPECT(sparse_list_numbers(s->mixed, MIXED_REFLECTANCE)[3] = 1.0f, ERR_OK, "");
}

TEST(declared_sizes_are_not_believed)
{
    list_case_believe_no_size(&lists);
}

TEST(cut_and_foreign_lists_fail)
{
    list_case_cut(&lists);
}

/* Runs all tests for both ways of packing. */
int main(void)
{
    int failed = unit_run("mixed pixels, quick");
    lists.packing = PACKING_SMALL;
    failed += unit_run("mixed pixels, small");
    return failed;
}
