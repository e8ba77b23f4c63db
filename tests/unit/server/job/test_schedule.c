/* The schedule: queues are filled evenly, never beyond what was asked for, and thinner when the
 * supply ends. */
#include <stdlib.h>

#include "server/fleet/schedule.h"
#include "tests/unit/unit.h"

static uint64_t sum(const uint32_t *give, size_t count)
{
    uint64_t total = 0;
    for (size_t i = 0; i < count; i++) total += give[i];
    return total;
}

TEST(fills_two_tiles_a_thread)
{
    const struct schedule_worker w[] = {{4, 100, 0, 0}, {1, 100, 0, 0}, {2, 100, 3, 0}};
    uint32_t give[3];
    schedule_share(w, 3, UINT64_MAX, give);
    assert_int_equal(give[0], 8);
    assert_int_equal(give[1], 2);
    assert_int_equal(give[2], 1);
    schedule_share(w, 3, 1000000, give);
    assert_int_equal(give[0], 8);
}

TEST(gives_no_more_than_wanted)
{
    const struct schedule_worker w[] = {
        {4, 3, 0, 0}, {4, 0, 0, 0}, {4, 100, 8, 0}, {4, 100, 200, 0}};
    uint32_t give[4];
    schedule_share(w, 4, UINT64_MAX, give);
    assert_int_equal(give[0], 3);
    assert_int_equal(give[1], 0);
    assert_int_equal(give[2], 0);
    assert_int_equal(give[3], 0);
}

TEST(spreads_a_short_supply)
{
    const struct schedule_worker w[] = {{4, 8, 0, 0}, {4, 8, 0, 0}, {4, 8, 0, 0}};
    uint32_t give[3];
    schedule_share(w, 3, 6, give);
    assert_int_equal(sum(give, 3), 6);
    for (int i = 0; i < 3; i++) assert_int_equal(give[i], 2);
    schedule_share(w, 3, 1, give);
    assert_int_equal(give[0], 1); /* ties go to the first */
    schedule_share(w, 3, 0, give);
    assert_int_equal(sum(give, 3), 0);
}

TEST(serves_the_idle_first)
{
    const struct schedule_worker w[] = {{2, 4, 2, 0}, {2, 4, 0, 0}};
    uint32_t give[2];
    schedule_share(w, 2, 2, give);
    assert_int_equal(give[0], 0);
    assert_int_equal(give[1], 2);
}

TEST(gives_by_threads)
{
    const struct schedule_worker w[] = {{16, 32, 0, 0}, {1, 2, 0, 0}};
    uint32_t give[2];
    schedule_share(w, 2, 17, give);
    assert_int_equal(sum(give, 2), 17);
    assert_int_equal(give[1], 1);
}

/* The nearer the end, the fewer tiles wait in a queue; every thread keeps its one. */
TEST(queues_thin_out)
{
    uint32_t before = UINT32_MAX;
    for (uint64_t supply = 64; supply > 0; supply--) {
        uint32_t depth = schedule_depth(4, 16, supply);
        assert_in_range(depth, 4, 8);
        assert_true(depth <= before);
        before = depth;
    }
    assert_int_equal(schedule_depth(4, 16, 32), 8);
    assert_int_equal(schedule_depth(4, 16, 1), 5);
}

/* At the end a slow worker gets nothing that the others would wait for; alone it gets all. */
TEST(leaves_the_last_tiles_to_the_fast)
{
    const struct schedule_worker w[] = {{1, 2, 0, 1000}, {1, 2, 1, 100}, {1, 2, 1, 100}};
    uint32_t give[3];
    schedule_share(w, 3, 40, give);
    assert_true(give[0] > 0); /* some 15 rounds are left for the fast ones */
    schedule_share(w, 3, 4, give);
    assert_int_equal(give[0], 0);
    assert_int_equal(sum(give + 1, 2), 2);
    schedule_share(w, 1, 4, give);
    assert_int_equal(give[0], 2);
    const struct schedule_worker unknown[] = {{1, 2, 0, 0}, {1, 2, 1, 100}};
    schedule_share(unknown, 2, 1, give);
    assert_int_equal(give[0], 1); /* who has not answered may be fast */
}

/* Who wants nothing now works, too: a short supply is not all for the one who asks first. */
TEST(counts_those_who_work)
{
    const struct schedule_worker w[] = {{4, 8, 0, 0}, {4, 0, 8, 0}, {4, 0, 8, 0}, {4, 0, 8, 0}};
    uint32_t give[4];
    schedule_share(w, 4, 8, give);
    assert_int_equal(give[0], 6);
}

TEST(holds_for_any_input)
{
    enum { WORKERS = 40 };
    uint64_t x = 88172645463325252u;
    for (int round = 0; round < 500; round++) {
        struct schedule_worker w[WORKERS];
        uint32_t give[WORKERS];
        for (int i = 0; i < WORKERS; i++) {
            x ^= x << 13, x ^= x >> 7, x ^= x << 17;
            w[i] = (struct schedule_worker){1 + (uint32_t)(x % 128), (uint32_t)(x >> 20) % 257,
                                            (uint32_t)(x >> 40) % 257,
                                            (double)(x >> 48 & 3) * (double)(x >> 50 & 1023)};
        }
        uint64_t supply = x % 3000;
        schedule_share(w, WORKERS, supply, give);
        assert_true(sum(give, WORKERS) <= supply);
        for (int i = 0; i < WORKERS; i++) {
            assert_true(give[i] <= w[i].want);
            assert_true(give[i] == 0 || give[i] + w[i].in_hand <= 2 * w[i].threads);
        }
    }
}
