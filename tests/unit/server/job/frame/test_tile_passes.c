/* A tile's passes follow each other, and leases hold in each of them. */
#include "tests/unit/server/job/frame/tile_queue_case.h"

static void lease(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t generation,
                  uint32_t pass)
{
    uint32_t got, under;
    assert_true(tile_queue_lease(q, worker, &got, &under));
    assert_int_equal(got, tile);
    assert_int_equal(under, generation);
    assert_int_equal(tile_queue_pass(q, got), pass);
}

static void finish(struct tile_queue *q, uint64_t worker, uint32_t tile, uint32_t generation)
{
    assert_int_equal(tile_queue_receive(q, worker, tile, generation), VERDICT_ACCEPTED);
    tile_queue_land(q, tile);
}

/* All tiles' first pass in their order, then all tiles' second: also when tiles land in
 * another order. */
TEST(gives_pass_after_pass)
{
    enum { PASSES = 5, TILES = 63 };
    struct tile_queue *q = make_passes(9 * 16, 7 * 16, 16, 32, PASSES);
    uint32_t order[TILES], again, generation;
    assert_int_equal(tile_queue_count(q), TILES * PASSES);
    for (uint32_t pass = 0; pass < PASSES; pass++) {
        assert_int_equal(tile_queue_waiting(q), TILES);
        for (uint32_t i = 0; i < TILES; i++) {
            assert_true(tile_queue_lease(q, ALICE, &again, &generation));
            if (pass == 0) order[i] = again;
            assert_int_equal(again, order[i]);
            assert_int_equal(generation, pass + 1);
            assert_int_equal(tile_queue_pass(q, again), pass);
        }
        assert_false(tile_queue_lease(q, ALICE, &again, &generation)); /* one lease a tile */
        assert_false(tile_queue_complete(q));
        for (uint32_t i = 0; i < TILES; i++)
            finish(q, ALICE, order[(i * 37 + 11) % TILES], pass + 1);
        assert_int_equal(tile_queue_landed(q), TILES * (pass + 1));
    }
    assert_true(tile_queue_complete(q));
    assert_int_equal(tile_queue_pass(q, 0), PASSES);
    assert_int_equal(tile_queue_reissued(q), 0);
    assert_false(tile_queue_lease(q, ALICE, &again, &generation));
    tile_queue_destroy(&q);
}

/* One worker brings each window to its end before it opens the next. */
TEST(ends_window_after_window)
{
    enum { PASSES = 3, TILES = 63, WINDOW = 10 };
    struct tile_queue *q = make_windows(9 * 16, 7 * 16, 16, 32, PASSES, WINDOW);
    uint32_t tile, generation, begun = 0, ended = 0;
    while (tile_queue_lease(q, ALICE, &tile, &generation)) {
        begun += tile_queue_pass(q, tile) == 0;
        finish(q, ALICE, tile, generation);
        ended += tile_queue_pass(q, tile) == PASSES;
        assert_in_range(begun - ended, 0, WINDOW);
    }
    assert_true(tile_queue_complete(q) && ended == TILES);
    tile_queue_destroy(&q);
}

/* Who has nothing left in a window begins the next one. */
TEST(idle_workers_open_the_next_window)
{
    struct tile_queue *q = make_windows(64, 32, 32, 64, 2, 1);
    lease(q, ALICE, 0, 1, 0);
    lease(q, BOB, 1, 1, 0);
    finish(q, BOB, 1, 1);
    finish(q, ALICE, 0, 1);
    lease(q, BOB, 0, 2, 1);
    lease(q, ALICE, 1, 2, 1);
    tile_queue_destroy(&q);
}

/* Whoever is left behind goes before those that are further. */
TEST(slow_tiles_catch_up)
{
    struct tile_queue *q = make_passes(64, 32, 32, 64, 4);
    lease(q, ALICE, 0, 1, 0);
    lease(q, BOB, 1, 1, 0);
    finish(q, BOB, 1, 1);
    lease(q, BOB, 1, 2, 1);
    finish(q, BOB, 1, 2);
    finish(q, ALICE, 0, 1);
    lease(q, ALICE, 0, 2, 1); /* tile 1 is at pass 2 */
    finish(q, ALICE, 0, 2);
    lease(q, ALICE, 0, 3, 2);
    lease(q, BOB, 1, 3, 2);
    tile_queue_destroy(&q);
}

/* A pass that came back keeps its pass; what was sent for an earlier one is a duplicate. */
TEST(leases_hold_in_every_pass)
{
    struct tile_queue *q = make_passes(32, 32, 32, 64, 3);
    lease(q, ALICE, 0, 1, 0);
    assert_int_equal(tile_queue_return(q, ALICE, 0, 1, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_int_equal(tile_queue_receive(q, CAROL, 0, 1), VERDICT_ACCEPTED); /* late, not begun */
    tile_queue_land(q, 0);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 1), VERDICT_DUPLICATE); /* while it waits */
    assert_int_equal(tile_queue_waiting(q), 1);
    lease(q, ALICE, 0, 2, 1);
    assert_int_equal(tile_queue_reissued(q), 0);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 1), VERDICT_DUPLICATE); /* while leased */
    assert_int_equal(tile_queue_return(q, ALICE, 0, 2, TILE_GIVEN_BACK), TILE_GOES_ON);
    lease(q, BOB, 0, 3, 1);
    assert_int_equal(tile_queue_reissued(q), 1);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 2), VERDICT_STALE);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 1), VERDICT_DUPLICATE);
    assert_int_equal(tile_queue_receive(q, BOB, 0, 3), VERDICT_ACCEPTED);
    tile_queue_reject(q, 0);
    lease(q, CAROL, 0, 4, 1);
    finish(q, CAROL, 0, 4);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 2), VERDICT_DUPLICATE);
    lease(q, BOB, 0, 5, 2);
    finish(q, BOB, 0, 5);
    assert_int_equal(tile_queue_receive(q, BOB, 0, 5), VERDICT_DUPLICATE);
    assert_true(tile_queue_complete(q));
    tile_queue_destroy(&q);
}

/* Of two leases of a tile the first result counts, whoever sends it; either may come back. */
TEST(a_copy_is_as_good)
{
    struct tile_queue *q = make_passes(32, 32, 32, 64, 4);
    uint32_t copy;
    assert_false(tile_queue_copy(q, BOB, 0, 1, &copy)); /* not leased */
    lease(q, ALICE, 0, 1, 0);
    assert_false(tile_queue_copy(q, ALICE, 0, 1, &copy)); /* has it */
    assert_false(tile_queue_copy(q, BOB, 0, 2, &copy));
    assert_false(tile_queue_copy(q, BOB, 9, 1, &copy));
    assert_true(tile_queue_copy(q, BOB, 0, 1, &copy));
    assert_int_equal(copy, 2);
    assert_false(tile_queue_copy(q, CAROL, 0, 1, &copy)); /* one is enough */
    finish(q, BOB, 0, 2);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 1), VERDICT_DUPLICATE);
    /* The first lease comes back: the copy stays, and is not given again. */
    lease(q, ALICE, 0, 3, 1);
    assert_true(tile_queue_copy(q, BOB, 0, 3, &copy));
    assert_int_equal(tile_queue_return(q, ALICE, 0, 3, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_int_equal(tile_queue_waiting(q), 0);
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 3), VERDICT_STALE);
    assert_true(tile_queue_copy(q, CAROL, 0, 4, &copy)); /* it is the tile's own now */
    assert_true(tile_queue_fault(q, BOB, 0, 4));
    finish(q, CAROL, 0, 5);
    /* A result that is refused leaves the tile to the other one; both gone, it waits. */
    lease(q, ALICE, 0, 6, 2);
    assert_true(tile_queue_copy(q, BOB, 0, 6, &copy));
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 6), VERDICT_ACCEPTED);
    tile_queue_reject(q, 0);
    assert_int_equal(tile_queue_waiting(q), 0);
    assert_int_equal(tile_queue_return(q, BOB, 0, 7, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_int_equal(tile_queue_waiting(q), 1);
    lease(q, ALICE, 0, 8, 2);
    assert_true(tile_queue_copy(q, BOB, 0, 8, &copy));
    assert_int_equal(tile_queue_receive(q, ALICE, 0, 8), VERDICT_ACCEPTED);
    assert_int_equal(tile_queue_receive(q, BOB, 0, 9), VERDICT_DUPLICATE);
    tile_queue_reject(q, 0);
    assert_int_equal(tile_queue_waiting(q), 1);
    assert_int_equal(tile_queue_copied(q), 5);
    tile_queue_destroy(&q);
}

/* A long frame may lose many leases, but not of one pass. */
TEST(each_pass_has_its_own_patience)
{
    struct tile_queue *q = make_passes(32, 32, 32, 64, 8);
    uint32_t tile, generation;
    for (uint32_t pass = 0; pass < 8; pass++) {
        for (int i = 1; i < TILE_QUEUE_RETURNS; i++) {
            assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
            assert_int_equal(tile_queue_return(q, ALICE, tile, generation, TILE_GIVEN_BACK),
                             TILE_GOES_ON);
        }
        assert_true(tile_queue_lease(q, BOB, &tile, &generation));
        assert_int_equal(tile_queue_pass(q, tile), pass);
        finish(q, BOB, tile, generation);
    }
    assert_true(tile_queue_complete(q));
    tile_queue_destroy(&q);
    q = make_passes(32, 32, 32, 64, 2);
    assert_true(fault_once(q, ALICE));
    assert_true(fault_once(q, BOB));
    lease(q, CAROL, 0, 3, 0);
    finish(q, CAROL, 0, 3);
    assert_true(fault_once(q, ALICE));
    assert_true(fault_once(q, BOB));
    assert_false(fault_once(q, CAROL));
    tile_queue_destroy(&q);
}
