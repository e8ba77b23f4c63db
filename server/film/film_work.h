#pragma once
/* The inside of the film, for film.c and film_gather.c alone. */
#include "server/film/film.h"
#include "server/film/passes.h"

/* A pass that landed while a block was reading its tile. */
struct pending_pass {
    struct samples *samples; /* owned */
    struct pass_counts counts;
    struct pending_pass *next;
};

struct film_tile {
    struct samples
        *samples;    /* owned; NULL before it has landed and once no block reads it any more */
    uint32_t merged; /* passes that `samples` holds */
    uint32_t landed; /* merged ones and those pending */
    uint32_t goal;   /* passes that it will have, as far as known */
    struct pass_counts counts;           /* of `samples` */
    uint32_t readers;                    /* blocks that are out and read it */
    uint32_t blocks_waiting;             /* blocks that read it and are not done */
    struct pending_pass *pending, *last; /* owned; in the order of the passes */
};

/* idle -> queued -> out -> idle, until its last time. A held block was to go out, but one of its
 * tiles has a pending pass; it is queued again when that is merged. One that rests goes from queued
 * to idle. */
enum block_state { BLOCK_IDLE, BLOCK_QUEUED, BLOCK_HELD, BLOCK_OUT, BLOCK_DONE };

struct film_block {
    enum block_state state;
    uint32_t round;         /* passes of the schedule that all its tiles have */
    uint32_t tiles_missing; /* tiles that have no more than these; after the schedule: that are
                               short of their goals */
    uint64_t rests_until;   /* on the film's clock, but for its last time */
};

struct film {
    const struct plan *plan; /* borrowed */
    struct scratch *scratch; /* borrowed: of patches; NULL: the heap */
    struct tile_grid grid;
    int32_t block_px, core_px, halo_px;
    int32_t columns, rows; /* of blocks */
    uint32_t tile_count, block_count, pass_count;
    uint32_t blocks_done;
    int32_t rows_done;                /* of blocks, from the top */
    bool keeps;                       /* whether tiles may be asked for more passes */
    bool more;                        /* whether they were */
    bool held;                        /* whether blocks are held back */
    struct film_tile *tiles;          /* owned */
    struct film_block *blocks;        /* owned */
    uint32_t *ready;                  /* owned; a ring: blocks in the order of becoming ready */
    uint32_t ready_first, ready_held; /* at most block_count: each block is in it once */
    uint64_t bytes, pending;
    uint64_t now_us;
};

/* Returns the half-open range of columns and rows, of tiles or blocks, that an area touches. */
static inline struct rect film_cells(struct rect area, int32_t side_px)
{
    return (struct rect){area.x0 / side_px, area.y0 / side_px, (area.x1 - 1) / side_px + 1,
                         (area.y1 - 1) / side_px + 1};
}

static inline struct rect film_image_rect(const struct film *film)
{
    return (struct rect){0, 0, film->grid.width_px, film->grid.height_px};
}

/* Returns the pixels that a block reads. */
static inline struct rect film_reach(const struct film *film, struct rect area)
{
    return rect_intersect(rect_grow(area, film->halo_px), film_image_rect(film));
}

/* Returns the tiles that a block reads. */
static inline struct rect film_tiles_of(const struct film *film, uint32_t block)
{
    return film_cells(film_reach(film, film_block_rect(film, block)), film->grid.side_px);
}

/* Returns the blocks that read a tile. */
static inline struct rect film_blocks_of(const struct film *film, uint32_t tile)
{
    return film_cells(film_reach(film, tile_grid_rect(&film->grid, tile)), film->block_px);
}

static inline uint32_t film_tile_at(const struct film *film, int32_t column, int32_t row)
{
    return (uint32_t)row * (uint32_t)film->grid.columns + (uint32_t)column;
}

static inline uint32_t film_block_at(const struct film *film, int32_t column, int32_t row)
{
    return (uint32_t)row * (uint32_t)film->columns + (uint32_t)column;
}
