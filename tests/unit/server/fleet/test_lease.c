/* Leases: what is found, what is forgotten, what has stalled. */
#include <stdlib.h>

#include "server/fleet/speculation.h"
#include "tests/unit/unit.h"

static void add(struct lease_table *t, uint64_t frame_id, uint32_t index, uint64_t since_ms,
                uint64_t answered)
{
    const struct lease lease = {.tile = {.frame_id = frame_id, .index = index, .generation = 1},
                                .since_ms = since_ms,
                                .answered_before = answered};
    assert_int_equal(lease_add(t, &lease), 0);
}

TEST(leases_are_found_and_forgotten)
{
    struct lease_table t = {0};
    for (uint32_t i = 0; i < 10; i++) add(&t, i % 2, i, 0, 0);
    assert_int_equal(lease_find(&t, 1, 3, 1), 3);
    assert_int_equal(lease_find(&t, 0, 3, 1), LEASE_NONE);
    assert_int_equal(lease_find(&t, 1, 3, 2), LEASE_NONE);
    assert_true(lease_has_tile(&t, 1, 3));
    lease_remove(&t, 3, 0);
    assert_false(lease_has_tile(&t, 1, 3));
    lease_forget_frame(&t, 0, 0);
    assert_int_equal(t.count, 4);
    assert_false(lease_has_frame(&t, 0));
    assert_int_equal(lease_find(&t, 1, 1, 1), 0); /* the order stays */
    assert_int_equal(lease_find(&t, 1, 9, 1), 3);
    lease_table_fini(&t);
}

TEST(a_table_has_an_end)
{
    struct lease_table t = {0};
    const struct lease more = {.tile = {.index = 9999}};
    for (uint32_t i = 0; i < LIMIT_TILES_IN_HAND; i++) add(&t, 1, i, 0, 0);
    assert_int_equal(lease_add(&t, &more), ERR_FULL);
    lease_table_fini(&t);
}

TEST(without_progress_all_have_stalled)
{
    struct lease_table t = {0};
    add(&t, 1, 0, 1000, 0);
    add(&t, 1, 1, 1900, 0);
    assert_int_equal(lease_stalled(&t, 1999, 900, 0, 10, 1000), LEASE_NONE);
    assert_int_equal(lease_stalled(&t, 2000, 1000, 0, 10, 1000), 0);
    assert_int_equal(lease_stalled(&t, 2000, 1001, 0, 10, 1000), LEASE_NONE);
    lease_remove(&t, 0, 0);
    assert_int_equal(lease_stalled(&t, 2000, 1000, 0, 10, 1000), LEASE_NONE); /* too young */
    lease_table_fini(&t);
}

/* One thread hangs while others go on: the tile is old, and many that came later are answered. */
TEST(an_overtaken_lease_has_stalled)
{
    struct lease_table t = {0};
    add(&t, 1, 0, 5000, 95);
    add(&t, 1, 1, 1000, 90);
    assert_int_equal(lease_stalled(&t, 5000, 4999, 99, 10, 1000), LEASE_NONE);
    assert_int_equal(lease_stalled(&t, 5000, 4999, 100, 10, 1000), 1);
    lease_table_fini(&t);
}

TEST(ended_leases_are_remembered_for_a_while)
{
    struct lease_past *past = malloc(sizeof *past);
    lease_past_init(past);
    assert_false(lease_past_has(past, 0, 0, 0));
    assert_false(lease_past_has(past, 0, UINT32_MAX, UINT32_MAX)); /* an empty place */
    lease_past_add(past, 1, 2, 3);
    assert_true(lease_past_has(past, 1, 2, 3));
    assert_false(lease_past_has(past, 1, 2, 4));
    lease_past_add(past, 2, 2, 3);
    lease_past_forget_frame(past, 1);
    assert_false(lease_past_has(past, 1, 2, 3));
    assert_true(lease_past_has(past, 2, 2, 3));
    for (uint32_t i = 0; i < LEASE_PAST_COUNT; i++) lease_past_add(past, 5, i, 1);
    assert_false(lease_past_has(past, 2, 2, 3));
    assert_true(lease_past_has(past, 5, 0, 1));
    free(past);
}

/* Threads take leases in their order; the pace follows what they took lately. */
TEST(the_pace_is_learnt)
{
    struct lease_table t = {.threads = 2};
    for (uint32_t i = 0; i < 4; i++) add(&t, 1, i, 1000, 0);
    assert_int_equal(lease_begun(&t), 2);
    assert_true(lease_pace_ms(&t, 9000) == 0);
    lease_answer(&t, 1, 1100); /* lease 2 is begun in its place */
    assert_true(t.pace_ms == 100);
    assert_int_equal(t.at[1].tile.index, 2);
    assert_int_equal(t.at[1].begun_ms, 1100);
    lease_answer(&t, 1, 1300);
    assert_true(t.pace_ms == 125);
    assert_true(lease_pace_ms(&t, 1310) == 310); /* lease 0 has been under work since 1000 */
    lease_remove(&t, 0, 1400);
    assert_true(t.pace_ms == 125);
    lease_answer(&t, 0, 1300);
    assert_true(t.pace_ms < 125 && t.pace_ms >= 1);
    assert_int_equal(lease_begun(&t), 0);
    /* Another frame's tiles may take another time; a frame that is over tells nothing any more. */
    add(&t, 2, 0, 2000, 0);
    lease_answer(&t, 0, 2010);
    assert_true(t.pace_ms == 10);
    lease_forget_frame(&t, 1, 2020);
    assert_true(t.pace_ms == 10);
    lease_forget_frame(&t, 2, 2020);
    assert_true(t.pace_ms == 0);
    lease_table_fini(&t);
}

static struct lease_table holder(uint32_t threads, double pace_ms, uint32_t leases,
                                 uint64_t since_ms)
{
    struct lease_table t = {.threads = threads, .pace_ms = pace_ms};
    for (uint32_t i = 0; i < leases; i++) add(&t, 1, i, since_ms, 0);
    return t;
}

/* A copy goes to who would be done well before: of the lease that is waited for longest. */
TEST(late_leases_are_found)
{
    struct lease_table idle = {.threads = 1, .pace_ms = 100}, slow = holder(1, 1000, 2, 5000),
                       even = holder(1, 100, 1, 5000), silent = holder(1, 0, 1, 5000);
    const struct lease_table *tables[] = {&idle, &even, &slow, NULL};
    struct speculation late;
    assert_true(speculation_find(tables, 4, 0, 5000, &late));
    assert_int_equal(late.holder, 2);
    assert_int_equal(late.at, 1); /* it is not begun, but will be the last */
    slow.at[1].copied = true;
    assert_true(speculation_find(tables, 4, 0, 5000, &late));
    assert_int_equal(late.at, 0);
    slow.at[0].copied = true;
    assert_false(speculation_find(tables, 4, 0, 5000, &late));
    assert_false(speculation_find(tables, 4, 0, 5250, &late));
    assert_true(speculation_find(tables, 4, 0, 5400, &late)); /* what should have come long ago */
    assert_int_equal(late.holder, 1);
    tables[1] = &silent;
    assert_false(speculation_find(tables, 4, 0, 5100, &late));
    assert_true(speculation_find(tables, 4, 0, 5400, &late));
    tables[0] = &slow; /* slow ones get no copies */
    tables[2] = &even;
    assert_false(speculation_find(tables, 3, 0, 9000, &late));
    lease_table_fini(&slow);
    lease_table_fini(&even);
    lease_table_fini(&silent);
}
