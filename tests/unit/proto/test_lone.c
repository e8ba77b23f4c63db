/* Lists of lone sub-samples: as they travel beside a tile's planes, and what is refused. */
#include <math.h>

#include "tests/unit/proto/list_case.h"

#define BIT(plane) PLANE_BIT(plane)

enum { PLACES = LIST_WIDTH * LIST_HEIGHT * 3 };

static void fill(struct samples *s, uint32_t count)
{
    assert_int_equal(lone_create(s->layout.lone_parts, count, &s->lone), 0);
    for (uint32_t e = 0; e < count; e++) {
        s->lone->words[e] = e * PLACES / count;
        for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
            for (uint32_t c = 0; c < 3; c++) {
                float *light = lone_values(s->lone, part, c);
                if (light) light[e] = 0.25f * (float)(1 + e * 31 + part * 7 + c);
            }
    }
}

static struct list_case lists = {
    .name = "lone", .planes = BIT(LONE), .places = PLACES, .fill = fill};

TEST(lists_round_trip)
{
    list_case_begin(&lists);
    list_case_round_trips(&lists);
    lists.plan.planes &= ~PLANES_GLOSSY; /* fewer parts */
    list_case_round_trips(&lists);
}

/* Planes that are left out take no list with them. */
TEST(lists_travel_without_planes)
{
    list_case_begin(&lists);
    struct samples *s = list_case_create(&lists, 5);
    memset(s->data, 0, s->layout.total_bytes);
    list_case_round_trip(&lists, s);
}

TEST(parts_follow_the_plan)
{
    list_case_begin(&lists);
    assert_int_equal(lone_parts(&lists.plan), 31);
    lists.plan.planes &= ~(BIT(INDIRECT_HALVES) | BIT(GLOSSY_HALF));
    assert_int_equal(lone_parts(&lists.plan),
                     1u << LONE_DIRECT | 1u << LONE_INDIRECT | 1u << LONE_GLOSSY);
    assert_int_equal(lone_words(lone_parts(&lists.plan)), 10);
    lists.plan.paths.spp = 4; /* these bring direct light */
    assert_int_equal(lone_parts(&lists.plan), 1u << LONE_INDIRECT | 1u << LONE_GLOSSY);
    lists.plan.planes &= ~(PLANES_BOUNCE_LIGHT | PLANES_GLOSSY);
    assert_int_equal(lone_parts(&lists.plan), 0);
}

/* Nothing of it costs a byte where the plan has none. */
TEST(other_plans_have_the_same_bytes)
{
    struct bytes_writer with, without;
    list_case_begin(&lists);
    struct samples *s = list_case_create(&lists, 0);
    list_case_pack(&lists, s, &with);
    samples_destroy(&s);
    lists.plan.planes &= ~BIT(LONE);
    s = list_case_create(&lists, 0);
    list_case_pack(&lists, s, &without);
    samples_destroy(&s);
    assert_int_equal(with.size_bytes, without.size_bytes);
    assert_memory_equal(with.data, without.data, with.size_bytes);
    bytes_writer_fini(&with);
    bytes_writer_fini(&without);
}

#define EXPECT(change, expected, place) LIST_EXPECT(&lists, change, expected, place)
#define LIGHT(part, c)                  lone_values(s->lone, LONE_##part, c)

TEST(hostile_entries_are_refused)
{
    EXPECT(s->lone->words[0] = 0, ERR_OK, "");
    EXPECT(s->lone->words[8] = PLACES - 1, ERR_OK, "");
    EXPECT(s->lone->words[8] = PLACES, ERR_RANGE, "lone");
    EXPECT(s->lone->words[8] = UINT32_MAX, ERR_RANGE, "lone");
    EXPECT(s->lone->words[4] = s->lone->words[3], ERR_RANGE, "lone");
    EXPECT(s->lone->words[4] = s->lone->words[3] - 1, ERR_RANGE, "lone");
    EXPECT(s->lone->words[0] = s->lone->words[1], ERR_RANGE, "lone");
    EXPECT(LIGHT(DIRECT, 0)[2] = NAN, ERR_NOT_FINITE, "lone.direct[0]");
    EXPECT(LIGHT(DIRECT, 2)[8] = INFINITY, ERR_NOT_FINITE, "lone.direct[2]");
    EXPECT(LIGHT(INDIRECT, 1)[0] = -1e-20f, ERR_RANGE, "lone.indirect[1]");
    EXPECT(LIGHT(INDIRECT_HALF, 1)[3] = -INFINITY, ERR_NOT_FINITE, "lone.indirect_half[1]");
    EXPECT(LIGHT(GLOSSY, 0)[5] = 2e30f, ERR_RANGE, "lone.glossy[0]");
    EXPECT(LIGHT(GLOSSY, 0)[5] = LONE_RADIANCE_MAX, ERR_OK, "");
    EXPECT(LIGHT(GLOSSY_HALF, 2)[5] = NAN, ERR_NOT_FINITE, "lone.glossy_half[2]");
    EXPECT(samples_u16(s, PLANE_SUB_DEPTH, s->lone->words[4] % 3)[s->lone->words[4] / 3] =
               half_from_float(SUB_DEPTH_MISS),
           ERR_RANGE, "lone");
}

TEST(declared_sizes_are_not_believed)
{
    list_case_believe_no_size(&lists);
}

TEST(cut_and_foreign_lists_fail)
{
    list_case_cut(&lists);
}

/* Damaged bytes are refused or unpack to numbers that are still allowed. */
TEST(damage_does_no_harm)
{
    struct bytes_writer w;
    uint64_t random = 7;
    uint32_t refused = 0;
    list_case_begin(&lists);
    struct samples *s = list_case_create(&lists, 40);
    list_case_pack(&lists, s, &w);
    const size_t tail = 1500;
    for (int i = 0; i < 4000; i++) {
        struct samples *back;
        struct fault fault;
        const size_t at = w.size_bytes - 1 - samples_case_random(&random) % tail;
        const uint8_t flip = (uint8_t)(1 + samples_case_random(&random) % 255);
        w.data[at] ^= flip;
        refused += list_case_unpack(&lists, w.data, w.size_bytes, &back, &fault) != 0;
        for (uint32_t e = 0; back && back->lone && e < back->lone->count; e++)
            assert_true(back->lone->words[e] < PLACES);
        samples_destroy(&back);
        w.data[at] ^= flip;
    }
    assert_in_range(refused, 100, 3999);
    bytes_writer_fini(&w);
    samples_destroy(&s);
}

/* A tile must fit a frame were all its sub-samples lone. */
TEST(room_is_kept_for_all)
{
    struct samples_layout layout;
    uint32_t l = 1;
    list_case_begin(&lists);
    lists.plan.planes &= ~BIT(LONE);
    for (lists.plan.indirect_strata_per_axis = l;
         samples_layout_init(&layout, &lists.plan, 0, 256, 256) == 0; l++)
        lists.plan.indirect_strata_per_axis = l + 1;
    lists.plan.indirect_strata_per_axis = l - 1; /* the most that fits */
    assert_int_equal(samples_layout_init(&layout, &lists.plan, 0, 256, 256), 0);
    const uint64_t left = LIMIT_FRAME_BYTES - layout.total_bytes;
    lists.plan.planes |= BIT(LONE);
    assert_int_equal(samples_layout_init(&layout, &lists.plan, 0, 256, 256),
                     left > 256u * 256 * 3 * 16 * 4 + 8192 ? 0 : ERR_LIMIT);
    lists.plan.indirect_strata_per_axis = 1;
    assert_int_equal(samples_layout_init(&layout, &lists.plan, 0, 256, 256), 0);
}

TEST(frees_nothing_twice)
{
    struct sparse_list *none = NULL;
    sparse_list_destroy(&none);
    assert_int_equal(sparse_list_bytes(NULL), 0);
}

/* Runs all tests for both ways of packing. */
int main(void)
{
    int failed = unit_run("lone sub-samples, quick");
    lists.packing = PACKING_SMALL;
    failed += unit_run("lone sub-samples, small");
    return failed;
}
