#pragma once
/* Queues of tiles and those that lease from them. */
#include "proto/error.h"
#include "server/job/frame/tile_queue.h"
#include "tests/unit/unit.h"

#define ALICE 101u
#define BOB   102u
#define CAROL 103u

static inline struct tile_queue *make_windows(int32_t width, int32_t height, int32_t side,
                                              int32_t cell, uint32_t passes, uint32_t window)
{
    struct tile_grid grid;
    struct tile_queue *q = NULL;
    assert_int_equal(tile_grid_init(&grid, width, height, side), 0);
    assert_int_equal(tile_queue_create(&grid, cell, passes, window, &q), 0);
    return q;
}

static inline struct tile_queue *make_passes(int32_t width, int32_t height, int32_t side,
                                             int32_t cell, uint32_t passes)
{
    return make_windows(width, height, side, cell, passes, UINT32_MAX);
}

static inline bool fault_once(struct tile_queue *q, uint64_t worker)
{
    uint32_t tile, generation;
    assert_true(tile_queue_lease(q, worker, &tile, &generation));
    assert_int_equal(tile, 0);
    return tile_queue_fault(q, worker, tile, generation);
}
