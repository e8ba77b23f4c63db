/* Tiles with priority go first, and each goes once under any priority. */
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/tile_queue.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

#define ALICE 101u

struct bench {
    struct tile_grid grid;
    struct tile_queue *q;
};

static struct bench make(int32_t width, int32_t height, int32_t side, int32_t cell, uint32_t passes,
                         uint32_t window)
{
    struct bench b;
    assert_int_equal(tile_grid_init(&b.grid, width, height, side), 0);
    assert_int_equal(tile_queue_create(&b.grid, cell, passes, window, &b.q), 0);
    return b;
}

static uint32_t lease(struct bench *b)
{
    uint32_t tile, generation;
    assert_true(tile_queue_lease(b->q, ALICE, &tile, &generation));
    return tile;
}

/* Leases one and lands it. */
static uint32_t trace(struct bench *b)
{
    uint32_t tile, generation;
    assert_true(tile_queue_lease(b->q, ALICE, &tile, &generation));
    assert_int_equal(tile_queue_receive(b->q, ALICE, tile, generation), VERDICT_ACCEPTED);
    tile_queue_land(b->q, tile);
    return tile;
}

static bool touches(const struct bench *b, uint32_t tile, struct rect region)
{
    return !rect_is_empty(rect_intersect(tile_grid_rect(&b->grid, tile), region));
}

/* Returns how many tiles go before the order of rows. */
static uint32_t probes_of(uint32_t tiles)
{
    const uint32_t most = tiles < 192 ? 16 : 32;
    return most < tiles / 2 ? most : tiles / 2;
}

/* What goes first tells early what the parts of a picture cost, in whatever part it begins to. */
TEST(a_picture_is_probed_first)
{
    static const int32_t sizes[][2] = {{2048, 1024}, {1280, 720}, {512, 512}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int32_t width = sizes[s][0], height = sizes[s][1];
        struct bench b = make(width, height, 64, 256, 1, UINT32_MAX);
        bool rows[4][8] = {0}, columns[4][8] = {0}; /* of halves to eighths */
        for (int i = 0; i < 16; i++) {
            const struct rect r = tile_grid_rect(&b.grid, lease(&b));
            for (int k = 1; k < 4; k++) {
                rows[k][((r.y0 + r.y1) << k) / (2 * height)] = true;
                columns[k][((r.x0 + r.x1) << k) / (2 * width)] = true;
            }
            for (int k = 1, n = 2; k < 4; k++, n *= 2)
                for (int at = 0; at < n && i + 1 == 2 * n; at++)
                    assert_true(rows[k][at] && columns[k][at]);
        }
        tile_queue_destroy(&b.q);
    }
}

TEST(a_region_goes_first)
{
    struct bench b = make(512, 512, 32, 64, 1, UINT32_MAX);
    const struct tile_priority priority = {.region = {300, 400, 401, 480}};
    int left = 12;
    for (int i = 0; i < (int)probes_of(256) + 20; i++)
        left -= touches(&b, lease(&b), priority.region);
    tile_queue_steer(b.q, &priority);
    /* 300..400 touches the columns 9 to 12, 400..479 the rows 12 to 14; probes are among them. */
    for (int i = 0; i < left; i++) assert_true(touches(&b, lease(&b), priority.region));
    assert_false(touches(&b, lease(&b), priority.region));
    tile_queue_destroy(&b.q);
}

static uint64_t away(int32_t x, int32_t y, struct rect cell)
{
    int32_t dx = x < cell.x0 ? cell.x0 - x : x >= cell.x1 ? x - cell.x1 + 1 : 0;
    int32_t dy = y < cell.y0 ? cell.y0 - y : y >= cell.y1 ? y - cell.y1 + 1 : 0;
    return (uint64_t)((int64_t)dx * dx + (int64_t)dy * dy);
}

TEST(cells_go_by_their_distance)
{
    struct bench b = make(500, 300, 16, 64, 1, UINT32_MAX);
    const struct tile_priority priority = {.has_near = true, .near_x = 333, .near_y = 111};
    tile_queue_steer(b.q, &priority);
    const uint32_t count = tile_queue_count(b.q);
    uint64_t last = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct rect r = tile_grid_rect(&b.grid, lease(&b));
        struct rect cell = {r.x0 / 64 * 64, r.y0 / 64 * 64, r.x0 / 64 * 64 + 64,
                            r.y0 / 64 * 64 + 64};
        uint64_t d = away(333, 111, cell);
        if (i < 16) assert_int_equal(d, 0); /* the point's own cell is whole before the next */
        assert_true(d >= last);
        last = d;
    }
    tile_queue_destroy(&b.q);
}

TEST(a_region_goes_before_a_point)
{
    struct bench b = make(512, 512, 64, 64, 1, UINT32_MAX);
    const struct tile_priority priority = {
        .region = {0, 0, 128, 64}, .has_near = true, .near_x = 500, .near_y = 10};
    tile_queue_steer(b.q, &priority);
    assert_int_equal(lease(&b), 1); /* of the region, the one nearer to the point */
    assert_int_equal(lease(&b), 0);
    assert_int_equal(lease(&b), 7);
    tile_queue_destroy(&b.q);
}

TEST(no_priority_is_the_order_of_the_start)
{
    struct bench a = make(512, 384, 32, 64, 1, UINT32_MAX);
    struct bench b = make(512, 384, 32, 64, 1, UINT32_MAX);
    const struct tile_priority priority = {.has_near = true, .near_x = 9, .near_y = 300},
                               none = {0};
    tile_queue_steer(b.q, &priority);
    tile_queue_steer(b.q, &none);
    while (tile_queue_waiting(a.q) > 0) assert_int_equal(lease(&a), lease(&b));
    tile_queue_destroy(&a.q);
    tile_queue_destroy(&b.q);
}

TEST(what_came_back_still_goes_first)
{
    struct bench b = make(256, 256, 64, 64, 1, UINT32_MAX);
    const struct tile_priority priority = {.region = {192, 192, 256, 256}};
    uint32_t first = lease(&b);
    tile_queue_steer(b.q, &priority);
    assert_int_equal(tile_queue_return(b.q, ALICE, first, 1, TILE_GIVEN_BACK), TILE_GOES_ON);
    assert_int_equal(lease(&b), first);
    assert_int_equal(lease(&b), 15);
    tile_queue_destroy(&b.q);
}

/* A region gets all its passes before anything else gets its first. */
TEST(a_region_is_brought_to_its_end)
{
    struct bench b = make(256, 256, 64, 64, 5, 2);
    const struct tile_priority priority = {.region = {128, 64, 256, 128}};
    tile_queue_steer(b.q, &priority);
    for (int i = 0; i < 10; i++) assert_true(touches(&b, trace(&b), priority.region));
    assert_false(touches(&b, trace(&b), priority.region));
    tile_queue_destroy(&b.q);
}

/* However the point moves: tiles between their passes stay few, none is given twice, all end. */
TEST(a_moving_point_begins_few)
{
    struct bench b = make(1024, 1024, 32, 64, 6, 8);
    const uint32_t tiles = tile_grid_count(&b.grid);
    struct random random = {7};
    uint32_t between = 0, most = 0;
    uint32_t *done = calloc(tiles, sizeof *done);
    while (!tile_queue_complete(b.q)) {
        struct tile_priority priority = {.has_near = true,
                                         .near_x = (int32_t)(random_bits(&random) % 1024),
                                         .near_y = (int32_t)(random_bits(&random) % 1024)};
        tile_queue_steer(b.q, &priority);
        uint32_t tile = trace(&b);
        between += ++done[tile] == 1;
        between -= done[tile] == 6;
        if (between > most) most = between;
        assert_true(done[tile] <= 6);
    }
    assert_true(most > 8 && most <= TILE_QUEUE_WINDOWS * 8);
    free(done);
    tile_queue_destroy(&b.q);
}

/* Is the tile what a cell before this one may wait for, whose blocks read `halo` pixels around? */
static bool is_borderer(struct rect tile, int32_t cell_px, int32_t halo)
{
    return tile.x0 % cell_px < halo || tile.y0 % cell_px < halo;
}

/* What the last tiles of a cell are, no cell before it reads; and rows of cells end one by one. */
TEST(nothing_waits_for_the_corner_that_is_last)
{
    static const int32_t sizes[][4] = {
        {512, 512, 64, 256}, {1280, 720, 64, 256}, {500, 300, 16, 128}, {640, 90, 32, 128}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        const int32_t cell = sizes[i][3], halo = cell / 2;
        struct bench b = make(sizes[i][0], sizes[i][1], sizes[i][2], cell, 1, UINT32_MAX);
        const uint32_t count = tile_queue_count(b.q);
        const uint32_t probes = probes_of(count);
        int32_t last_cell = -1;
        bool inside = false;
        for (uint32_t k = 0; k < probes; k++) lease(&b);
        for (uint32_t k = probes; k < count; k++) {
            const struct rect r = tile_grid_rect(&b.grid, lease(&b));
            const int32_t at = r.y0 / cell * 1000 + r.x0 / cell;
            assert_true(at >= last_cell);
            if (at > last_cell) inside = false;
            last_cell = at;
            if (!is_borderer(r, cell, halo)) inside = true;
            assert_false(inside && is_borderer(r, cell, halo));
        }
        tile_queue_destroy(&b.q);
    }
}

/* In a later round the cell with the most error is drawn first, with what it reads around it, and
 * each tile goes on to its last pass. */
TEST(a_round_begins_where_errors_are)
{
    enum { TILES = 12 * 8, NOISY = 5 * 12 + 6, LESS = 1 * 12 + 10 };
    struct bench b = make(12 * 32, 8 * 32, 32, 64, 1, UINT32_MAX);
    double errors[TILES] = {0.0};
    uint32_t order[TILES];
    bool seen[TILES] = {false};
    errors[NOISY] = 3.0;
    errors[LESS] = 1.0;
    assert_int_equal(tile_order_by_errors(&b.grid, 64, 10, errors, order), 0);
    for (uint32_t i = 0; i < TILES; i++) {
        assert_true(order[i] < TILES && !seen[order[i]]);
        seen[order[i]] = true;
    }
    for (uint32_t i = 0; i < 16; i++) /* of the cell, and a ring around it */
        assert_true(touches(&b, order[i], (struct rect){192 - 10, 128 - 10, 256 + 10, 192 + 10}));
    for (uint32_t i = 16; i < 25; i++) /* of the other, at the border */
        assert_true(touches(&b, order[i], (struct rect){320 - 10, 0, 384, 64 + 10}));
    for (uint32_t i = 0; i < TILES; i++) trace(&b);
    tile_queue_reorder(b.q, order);
    for (uint32_t i = 0; i < TILES; i++) tile_queue_extend(b.q, i, 1 + i % 3);
    for (uint32_t i = 0; i < TILES; i++)
        for (uint32_t pass = 0; pass < 1 + order[i] % 3; pass++)
            assert_int_equal(trace(&b), order[i]);
    assert_true(tile_queue_complete(b.q));
    tile_queue_destroy(&b.q);
}
