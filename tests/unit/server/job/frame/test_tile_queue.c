/* Every tile is given once while its lease holds, and a result counts only under it. */
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/job/frame/tile_queue_case.h"

static struct tile_queue *make(int32_t width, int32_t height, int32_t side, int32_t cell)
{
    return make_passes(width, height, side, cell, 1);
}

TEST(gives_each_tile_once)
{
    static const int32_t sizes[][3] = {{720, 720, 32}, {1000, 37, 16},  {9, 700, 8},
                                       {333, 517, 24}, {640, 480, 256}, {1, 1, 8}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        struct tile_queue *q = make(sizes[s][0], sizes[s][1], sizes[s][2], 64);
        uint32_t count = tile_queue_count(q), tile, generation;
        bool *seen = calloc(count, sizeof *seen);
        for (uint32_t i = 0; i < count; i++) {
            assert_int_equal(tile_queue_waiting(q), count - i);
            assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
            assert_true(tile < count && !seen[tile]);
            assert_int_equal(generation, 1);
            seen[tile] = true;
        }
        assert_false(tile_queue_lease(q, ALICE, &tile, &generation));
        assert_int_equal(tile_queue_reissued(q), 0);
        free(seen);
        tile_queue_destroy(&q);
        assert_null(q);
    }
}

/* Cells of 64 px with tiles of 32: after the sixteen tiles that go first, a cell is filled before
 * the next, row by row. */
TEST(fills_cell_after_cell)
{
    struct tile_grid grid;
    struct tile_queue *q = make(512, 128, 32, 64);
    uint32_t tile, generation;
    int32_t last = 0;
    tile_grid_init(&grid, 512, 128, 32);
    for (int i = 0; i < 16; i++) assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
    while (tile_queue_lease(q, ALICE, &tile, &generation)) {
        const struct rect r = tile_grid_rect(&grid, tile);
        const int32_t cell = r.y0 / 64 * 8 + r.x0 / 64;
        assert_true(cell >= last);
        last = cell;
    }
    assert_int_equal(last, 15);
    tile_queue_destroy(&q);
}

TEST(counts_a_result_once)
{
    struct tile_queue *q = make(64, 64, 32, 64);
    uint32_t tile, generation;
    assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
    assert_int_equal(tile_queue_receive(q, BOB, tile, generation), VERDICT_FOREIGN);
    assert_int_equal(tile_queue_receive(q, ALICE, tile, generation + 1), VERDICT_FOREIGN);
    assert_int_equal(tile_queue_receive(q, ALICE, 4, 1), VERDICT_FOREIGN);
    assert_int_equal(tile_queue_receive(q, ALICE, tile, 0), VERDICT_FOREIGN);
    assert_int_equal(tile_queue_receive(q, ALICE, tile, generation), VERDICT_ACCEPTED);
    assert_int_equal(tile_queue_receive(q, ALICE, tile, generation), VERDICT_DUPLICATE);
    tile_queue_land(q, tile);
    assert_int_equal(tile_queue_receive(q, ALICE, tile, generation), VERDICT_DUPLICATE);
    assert_int_equal(tile_queue_landed(q), 1);
    /* A return after the result is void. */
    assert_int_equal(tile_queue_return(q, ALICE, tile, generation, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_int_equal(tile_queue_waiting(q), 3);
    tile_queue_destroy(&q);
}

TEST(passes_a_lease_on)
{
    struct tile_queue *q = make(64, 64, 32, 64);
    uint32_t first, again, generation, next;
    assert_true(tile_queue_lease(q, ALICE, &first, &generation));
    assert_int_equal(tile_queue_return(q, BOB, first, generation, TILE_GIVEN_BACK),
                     TILE_GOES_ON); /* not his: ignored */
    assert_int_equal(tile_queue_waiting(q), 3);
    assert_int_equal(tile_queue_return(q, ALICE, first, generation, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_true(tile_queue_lease(q, BOB, &again, &next));
    assert_int_equal(again, first); /* what came back goes first */
    assert_int_equal(next, generation + 1);
    assert_int_equal(tile_queue_reissued(q), 1);
    assert_int_equal(tile_queue_receive(q, ALICE, first, generation), VERDICT_STALE);
    assert_int_equal(tile_queue_receive(q, BOB, first, next), VERDICT_ACCEPTED);
    tile_queue_reject(q, first);
    assert_int_equal(tile_queue_waiting(q), 4);
    assert_true(tile_queue_lease(q, CAROL, &again, &next));
    assert_int_equal(again, first);
    assert_int_equal(next, generation + 2);
    tile_queue_destroy(&q);
}

/* A worker whose link broke comes back as another one, with the result in its hand. */
TEST(takes_a_late_result_of_a_waiting_tile)
{
    struct tile_queue *q = make(64, 64, 32, 64);
    uint32_t tiles[3], generation, again;
    for (int i = 0; i < 3; i++) assert_true(tile_queue_lease(q, ALICE, &tiles[i], &generation));
    for (int i = 0; i < 3; i++)
        assert_int_equal(tile_queue_return(q, ALICE, tiles[i], 1, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_int_equal(tile_queue_receive(q, CAROL, tiles[1], 2), VERDICT_FOREIGN);
    assert_int_equal(tile_queue_receive(q, CAROL, tiles[1], 1), VERDICT_ACCEPTED);
    assert_int_equal(tile_queue_receive(q, CAROL, tiles[1], 1), VERDICT_DUPLICATE);
    assert_int_equal(tile_queue_waiting(q), 3);
    tile_queue_land(q, tiles[1]);
    assert_true(tile_queue_lease(q, BOB, &again, &generation));
    assert_int_equal(again, tiles[2]);
    assert_true(tile_queue_lease(q, BOB, &again, &generation));
    assert_int_equal(again, tiles[0]);
    assert_int_equal(tile_queue_receive(q, CAROL, tiles[0], 1), VERDICT_STALE);
    assert_true(tile_queue_lease(q, BOB, &again, &generation));
    assert_false(tile_queue_lease(q, BOB, &again, &generation));
    tile_queue_destroy(&q);
}

TEST(fails_by_three_different_workers)
{
    struct tile_queue *q = make(32, 32, 32, 64);
    assert_true(fault_once(q, ALICE));
    assert_true(fault_once(q, ALICE));
    assert_true(fault_once(q, BOB));
    assert_true(fault_once(q, ALICE));
    assert_false(fault_once(q, CAROL));
    assert_false(fault_once(q, 104)); /* and stays failed */
    tile_queue_destroy(&q);
}

TEST(fails_when_a_tile_never_stays)
{
    struct tile_queue *q = make(32, 32, 32, 64);
    uint32_t tile, generation;
    for (int i = 1; i <= TILE_QUEUE_RETURNS; i++) {
        assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
        assert_int_equal(tile_queue_return(q, ALICE, tile, generation, TILE_GIVEN_BACK),
                         i < TILE_QUEUE_RETURNS ? TILE_GOES_ON : TILE_CAME_BACK_OFTEN);
    }
    tile_queue_destroy(&q);
}

TEST(a_tile_that_ends_its_workers_is_deadly)
{
    struct tile_queue *q = make(64, 32, 32, 64); /* two tiles */
    uint32_t tile, generation, other, unused;
    assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
    assert_false(tile_queue_gives_suspect(q));
    assert_int_equal(tile_queue_return(q, ALICE, tile, generation, TILE_DIED), TILE_GOES_ON);
    assert_true(tile_queue_gives_suspect(q) && tile_queue_is_suspect(q, tile));
    for (int death = 2; death <= TILE_QUEUE_DEATHS; death++) {
        assert_true(tile_queue_lease(q, BOB, &other, &generation));
        assert_int_equal(other, tile);
        assert_false(tile_queue_gives_suspect(q));
        assert_false(tile_queue_copy(q, CAROL, tile, generation, &unused)); /* one at a time */
        assert_int_equal(tile_queue_return(q, BOB, tile, generation, TILE_DIED),
                         death < TILE_QUEUE_DEATHS ? TILE_GOES_ON : TILE_IS_DEADLY);
    }
    tile_queue_destroy(&q);
}

/* A tile may end as many more as have died meanwhile at tiles that nobody suspected. */
TEST(farms_that_die_make_no_tile_deadly)
{
    struct tile_queue *q = make(160, 32, 32, 64); /* five tiles */
    uint32_t tile[5], generation[5], again, given;
    for (uint64_t k = 0; k < 5; k++)
        assert_true(tile_queue_lease(q, 100 + k, &tile[k], &generation[k]));
    for (uint64_t k = 0; k < 4; k++)
        assert_int_equal(tile_queue_return(q, 100 + k, tile[k], generation[k], TILE_DIED),
                         TILE_GOES_ON);
    for (uint64_t death = 2; death <= 4; death++) {
        uint64_t worker = 200 * death; /* others take what else is suspect */
        do assert_true(tile_queue_lease(q, ++worker, &again, &given));
        while (again != tile[0]);
        assert_int_equal(tile_queue_return(q, worker, again, given, TILE_DIED),
                         death < 4 ? TILE_GOES_ON : TILE_IS_DEADLY);
    }
    tile_queue_destroy(&q);
}

TEST(who_comes_back_has_not_died)
{
    struct tile_queue *q = make(32, 32, 32, 64);
    uint32_t tile, generation;
    for (uint64_t worker = 100; worker < 108; worker++) {
        assert_true(tile_queue_lease(q, worker, &tile, &generation));
        assert_int_equal(tile_queue_return(q, worker, tile, generation, TILE_DIED), TILE_GOES_ON);
        tile_queue_survived(q, worker);
        assert_false(tile_queue_is_suspect(q, tile));
    }
    tile_queue_destroy(&q);
}

TEST(what_lands_is_no_suspect)
{
    struct tile_queue *q = make(32, 32, 32, 64);
    uint32_t tile, generation;
    for (int i = 0; i < 2; i++) {
        assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
        assert_int_equal(tile_queue_return(q, ALICE, tile, generation, TILE_DIED), TILE_GOES_ON);
    }
    assert_true(tile_queue_lease(q, BOB, &tile, &generation));
    assert_int_equal(tile_queue_receive(q, BOB, tile, generation), VERDICT_ACCEPTED);
    tile_queue_land(q, tile);
    assert_false(tile_queue_is_suspect(q, tile));
    tile_queue_extend(q, tile, 1);
    assert_false(tile_queue_gives_suspect(q));
    for (int i = 0; i < 2; i++) { /* the next pass has its own count */
        assert_true(tile_queue_lease(q, ALICE, &tile, &generation));
        assert_int_equal(tile_queue_return(q, ALICE, tile, generation, TILE_DIED), TILE_GOES_ON);
    }
    tile_queue_destroy(&q);
}

/* Random workers that finish, return, fault and send late: in the end every tile landed
 * once, or once in each pass. */
static void survive(uint32_t passes)
{
    struct tile_queue *q = make_passes(300, 200, 16, 64, passes);
    uint32_t count = tile_queue_count(q), landed = 0, seed = 7;
    struct {
        uint32_t tile, generation;
        uint64_t worker;
    } held[64];
    unsigned holding = 0;
    while (!tile_queue_complete(q)) {
        seed = seed * 1664525u + 1013904223u;
        uint64_t worker = 1 + (seed >> 20) % 5;
        if (holding < 64 && (seed >> 28) < 9) {
            uint32_t tile, generation;
            if (tile_queue_lease(q, worker, &tile, &generation)) {
                held[holding].tile = tile;
                held[holding].generation = generation;
                held[holding++].worker = worker;
                continue;
            }
        }
        if (holding == 0) continue;
        unsigned at = (seed >> 8) % holding;
        uint32_t tile = held[at].tile, generation = held[at].generation;
        worker = held[at].worker;
        unsigned what = (seed >> 16) % 8;
        /* Some come back and are sent late: at once, by another name, or after others were leased.
         */
        if (what == 0)
            assert_int_equal(tile_queue_return(q, worker, tile, generation, TILE_GIVEN_BACK),
                             TILE_GOES_ON);
        if (what == 0 && seed & 64) continue;
        if (what == 0) worker = 9;
        if (tile_queue_receive(q, worker, tile, generation) == VERDICT_ACCEPTED) {
            if (what == 1)
                tile_queue_reject(q, tile);
            else {
                tile_queue_land(q, tile);
                landed++;
            }
        }
        held[at] = held[--holding];
    }
    assert_int_equal(landed, count);
    assert_int_equal(tile_queue_landed(q), count);
    tile_queue_destroy(&q);
}

TEST(survives_any_order)
{
    survive(1);
    survive(7);
}

static bool is_even(void *ctx, uint32_t tile)
{
    (void)ctx;
    return tile % 2 == 0;
}

/* Results that are there already: their tiles are given to nobody, in whatever order they land. */
TEST(tiles_are_taken)
{
    struct tile_grid grid;
    struct tile_queue *q;
    uint32_t taken[16], order[16], tile, generation;
    assert_int_equal(tile_grid_init(&grid, 64, 64, 16), 0);
    assert_int_equal(tile_queue_create(&grid, 32, 2, 16, &q), 0);
    for (uint32_t i = 0; i < 16; i++) {
        assert_true(tile_queue_lease(q, 1, &order[i], &generation));
        assert_int_equal(tile_queue_passes(q, order[i]), 2);
    }
    tile_queue_destroy(&q);
    assert_int_equal(tile_queue_create(&grid, 32, 2, 16, &q), 0);
    assert_int_equal(tile_queue_take(q, is_even, NULL, taken), 8);
    assert_int_equal(tile_queue_waiting(q), 8);
    for (uint32_t i = 0, even = 0; i < 16; i++)
        if (order[i] % 2 == 0) assert_int_equal(taken[even++], order[i]);
    assert_int_equal(tile_queue_receive(q, 1, taken[0], 1), VERDICT_FOREIGN);
    /* One has both passes there, one the first, one is not there after all. */
    tile_queue_land_and_take(q, taken[0]);
    tile_queue_land(q, taken[0]);
    tile_queue_land(q, taken[1]);
    tile_queue_give_up(q, taken[2]);
    for (uint32_t i = 3; i < 8; i++) {
        tile_queue_land_and_take(q, taken[i]);
        assert_int_equal(tile_queue_pass(q, taken[i]), 1);
        tile_queue_land(q, taken[i]);
    }
    /* Eight odd ones and the third have two passes to go, the second one. */
    unsigned leases = 0;
    while (tile_queue_lease(q, 1, &tile, &generation)) {
        assert_true(tile % 2 == 1 || tile == taken[1] || tile == taken[2]);
        assert_int_equal(tile_queue_receive(q, 1, tile, generation), VERDICT_ACCEPTED);
        tile_queue_land(q, tile);
        leases++;
    }
    assert_int_equal(leases, 19);
    assert_true(tile_queue_complete(q));
    assert_true(tile_queue_reissued(q) == 0);
    tile_queue_destroy(&q);
}
