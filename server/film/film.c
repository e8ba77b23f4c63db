#include "server/film/film.h"

#include <assert.h>
#include <stdlib.h>

#include "server/film/gather.h"

struct film_tile {
    struct samples
        *samples; /* owned; NULL before it has landed and when nobody needs it any more */
    uint32_t blocks_waiting; /* blocks that read it and are not done */
    bool landed;
};

struct film_block {
    uint32_t tiles_missing; /* tiles that it reads and that have not landed */
    bool done;
};

struct film {
    const struct plan *plan; /* borrowed */
    struct tile_grid grid;
    int32_t block_px, halo_px;
    int32_t columns, rows; /* of blocks */
    uint32_t tile_count, block_count;
    uint32_t blocks_done;
    struct film_tile *tiles;   /* owned */
    struct film_block *blocks; /* owned */
    uint32_t *ready;           /* owned; blocks in the order in which they became ready */
    uint32_t ready_first, ready_end;
    uint64_t bytes;
};

/* A half-open range of columns and rows, of tiles or of blocks. */
static struct rect cells(struct rect area, int32_t side_px)
{
    return (struct rect){area.x0 / side_px, area.y0 / side_px, (area.x1 - 1) / side_px + 1,
                         (area.y1 - 1) / side_px + 1};
}

static struct rect image_rect(const struct film *film)
{
    return (struct rect){0, 0, film->grid.width_px, film->grid.height_px};
}

struct rect film_block_rect(const struct film *film, uint32_t block)
{
    int32_t x = (int32_t)(block % (uint32_t)film->columns) * film->block_px;
    int32_t y = (int32_t)(block / (uint32_t)film->columns) * film->block_px;
    return rect_intersect((struct rect){x, y, x + film->block_px, y + film->block_px},
                          image_rect(film));
}

uint32_t film_block_count(const struct film *film)
{
    return film->block_count;
}

/* What a block reads. */
static struct rect reach(const struct film *film, struct rect area)
{
    return rect_intersect(rect_grow(area, film->halo_px), image_rect(film));
}

/* Tiles that a block reads. */
static struct rect tiles_of(const struct film *film, uint32_t block)
{
    return cells(reach(film, film_block_rect(film, block)), film->grid.side_px);
}

/* Blocks that read a tile. */
static struct rect blocks_of(const struct film *film, uint32_t tile)
{
    return cells(reach(film, tile_grid_rect(&film->grid, tile)), film->block_px);
}

static uint32_t tile_at(const struct film *film, int32_t column, int32_t row)
{
    return (uint32_t)row * (uint32_t)film->grid.columns + (uint32_t)column;
}

static uint32_t block_at(const struct film *film, int32_t column, int32_t row)
{
    return (uint32_t)row * (uint32_t)film->columns + (uint32_t)column;
}

static void count_needs(struct film *film)
{
    for (uint32_t i = 0; i < film->tile_count; i++) {
        film->tiles[i].blocks_waiting = (uint32_t)rect_area(blocks_of(film, i));
    }
    for (uint32_t i = 0; i < film->block_count; i++) {
        film->blocks[i].tiles_missing = (uint32_t)rect_area(tiles_of(film, i));
    }
}

int film_create(const struct plan *plan, int32_t block_px, int32_t halo_px, struct film **out)
{
    *out = NULL;
    if (block_px < 1 || block_px > LIMIT_IMAGE_SIDE_PX) return ERR_RANGE;
    if (halo_px < 0 || halo_px > LIMIT_IMAGE_SIDE_PX) return ERR_RANGE;
    struct film *film = calloc(1, sizeof *film);
    if (!film) return ERR_MEMORY;
    film->plan = plan;
    film->block_px = block_px;
    film->halo_px = halo_px;
    int error = tile_grid_init(&film->grid, plan->width_px, plan->height_px, plan->tile_px);
    if (error) goto fail;
    film->columns = (plan->width_px + block_px - 1) / block_px;
    film->rows = (plan->height_px + block_px - 1) / block_px;
    film->tile_count = tile_grid_count(&film->grid);
    film->block_count = (uint32_t)film->columns * (uint32_t)film->rows;
    film->tiles = calloc(film->tile_count, sizeof *film->tiles);
    film->blocks = calloc(film->block_count, sizeof *film->blocks);
    film->ready = calloc(film->block_count, sizeof *film->ready);
    error = ERR_MEMORY;
    if (!film->tiles || !film->blocks || !film->ready) goto fail;
    count_needs(film);
    *out = film;
    return 0;
fail:
    film_destroy(&film);
    return error;
}

void film_destroy(struct film **out)
{
    struct film *film = *out;
    if (!film) return;
    for (uint32_t i = 0; film->tiles && i < film->tile_count; i++) {
        if (film->tiles[i].samples) samples_destroy(&film->tiles[i].samples);
    }
    free(film->tiles);
    free(film->blocks);
    free(film->ready);
    free(film);
    *out = NULL;
}

static bool fits(const struct film *film, uint32_t tile, const struct samples *samples)
{
    struct rect r = tile_grid_rect(&film->grid, tile);
    return samples->layout.width_px == rect_width(r) && samples->layout.height_px == rect_height(r);
}

int film_land(struct film *film, uint32_t tile, struct samples *samples)
{
    if (tile >= film->tile_count) return ERR_RANGE;
    struct film_tile *t = &film->tiles[tile];
    if (t->landed) return ERR_EXISTS;
    if (!fits(film, tile, samples)) return ERR_MISMATCH;
    t->landed = true;
    t->samples = samples;
    film->bytes += samples->layout.total_bytes;
    struct rect b = blocks_of(film, tile);
    for (int32_t row = b.y0; row < b.y1; row++) {
        for (int32_t column = b.x0; column < b.x1; column++) {
            uint32_t block = block_at(film, column, row);
            if (--film->blocks[block].tiles_missing == 0) film->ready[film->ready_end++] = block;
        }
    }
    return 0;
}

bool film_next_ready(struct film *film, uint32_t *block)
{
    if (film->ready_first == film->ready_end) return false;
    *block = film->ready[film->ready_first++];
    return true;
}

int film_gather(const struct film *film, uint32_t block, struct patch **out)
{
    struct patch *patch;
    *out = NULL;
    assert(block < film->block_count && film->blocks[block].tiles_missing == 0);
    int error = patch_create(film->plan, reach(film, film_block_rect(film, block)), &patch);
    if (error) return error;
    struct rect t = tiles_of(film, block);
    for (int32_t row = t.y0; row < t.y1; row++) {
        for (int32_t column = t.x0; column < t.x1; column++) {
            uint32_t tile = tile_at(film, column, row);
            gather_tile(film->plan, film->tiles[tile].samples, tile_grid_rect(&film->grid, tile),
                        patch);
        }
    }
    *out = patch;
    return 0;
}

static void release(struct film *film, struct film_tile *tile)
{
    if (--tile->blocks_waiting > 0) return;
    film->bytes -= tile->samples->layout.total_bytes;
    samples_destroy(&tile->samples);
}

void film_block_done(struct film *film, uint32_t block)
{
    struct film_block *b = &film->blocks[block];
    assert(block < film->block_count && b->tiles_missing == 0 && !b->done);
    b->done = true;
    film->blocks_done++;
    struct rect t = tiles_of(film, block);
    for (int32_t row = t.y0; row < t.y1; row++) {
        for (int32_t column = t.x0; column < t.x1; column++) {
            release(film, &film->tiles[tile_at(film, column, row)]);
        }
    }
}

bool film_complete(const struct film *film)
{
    return film->blocks_done == film->block_count;
}

uint64_t film_bytes(const struct film *film)
{
    return film->bytes;
}
