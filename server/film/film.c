#include "server/film/film.h"

#include <assert.h>
#include <stdlib.h>

#include "server/film/film_work.h"

struct rect film_block_rect(const struct film *film, uint32_t block)
{
    int32_t x = (int32_t)(block % (uint32_t)film->columns) * film->block_px;
    int32_t y = (int32_t)(block / (uint32_t)film->columns) * film->block_px;
    return rect_intersect((struct rect){x, y, x + film->block_px, y + film->block_px},
                          film_image_rect(film));
}

uint32_t film_block_count(const struct film *film)
{
    return film->block_count;
}

/* Calls visit for every tile that a block reads. */
static void each_tile(struct film *film, uint32_t block,
                      void (*visit)(struct film *film, uint32_t tile))
{
    struct rect t = film_tiles_of(film, block);
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++)
            visit(film, film_tile_at(film, column, row));
}

static void count_needs(struct film *film)
{
    for (uint32_t i = 0; i < film->tile_count; i++) {
        film->tiles[i].goal = film->pass_count;
        film->tiles[i].blocks_waiting = (uint32_t)rect_area(film_blocks_of(film, i));
    }
    for (uint32_t i = 0; i < film->block_count; i++) {
        film->blocks[i].tiles_missing = (uint32_t)rect_area(film_tiles_of(film, i));
    }
}

int film_create(const struct plan *plan, int32_t block_px, int32_t core_px, int32_t halo_px,
                struct film **out)
{
    *out = NULL;
    if (block_px < 1 || block_px > LIMIT_IMAGE_SIDE_PX) return ERR_RANGE;
    if (core_px < 0 || core_px > halo_px || halo_px > LIMIT_IMAGE_SIDE_PX) return ERR_RANGE;
    struct film *film = calloc(1, sizeof *film);
    if (!film) return ERR_MEMORY;
    film->plan = plan;
    film->block_px = block_px;
    film->core_px = core_px;
    film->halo_px = halo_px;
    int error = tile_grid_init(&film->grid, plan->width_px, plan->height_px, plan->tile_px);
    if (error) goto fail;
    film->columns = (plan->width_px + block_px - 1) / block_px;
    film->rows = (plan->height_px + block_px - 1) / block_px;
    film->tile_count = tile_grid_count(&film->grid);
    film->block_count = (uint32_t)film->columns * (uint32_t)film->rows;
    film->pass_count = plan_pass_count(plan);
    film->keeps = plan_has_rounds(plan);
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

/* Takes the first of what waits for a tile; the samples are the caller's. */
static struct samples *take_pending(struct film *film, struct film_tile *t,
                                    struct pass_counts *counts)
{
    struct pending_pass *first = t->pending;
    struct samples *samples = first->samples;
    *counts = first->counts;
    t->pending = first->next;
    if (!t->pending) t->last = NULL;
    free(first);
    film->pending--;
    return samples;
}

void film_destroy(struct film **out)
{
    struct film *film = *out;
    if (!film) return;
    for (uint32_t i = 0; film->tiles && i < film->tile_count; i++) {
        struct film_tile *t = &film->tiles[i];
        while (t->pending) {
            struct pass_counts counts;
            struct samples *samples = take_pending(film, t, &counts);
            samples_destroy(&samples);
        }
        samples_destroy(&t->samples);
    }
    free(film->tiles);
    free(film->blocks);
    free(film->ready);
    free(film);
    *out = NULL;
}

static bool fits(const struct film *film, uint32_t tile, uint32_t pass,
                 const struct samples *samples)
{
    struct rect r = tile_grid_rect(&film->grid, tile);
    const uint64_t planes = plan_pass_planes(film->plan, pass);
    return samples->layout.width_px == rect_width(r) &&
           samples->layout.height_px == rect_height(r) && samples->layout.planes == planes;
}

/* Tiles of a block that have no more passes than its round; the round grows with the slowest. */
static void begin_round(struct film *film, uint32_t block)
{
    struct film_block *b = &film->blocks[block];
    struct rect t = film_tiles_of(film, block);
    b->round = UINT32_MAX;
    for (int32_t row = t.y0; row < t.y1; row++) {
        for (int32_t column = t.x0; column < t.x1; column++) {
            const uint32_t merged = film->tiles[film_tile_at(film, column, row)].merged;
            if (merged < b->round) {
                b->round = merged;
                b->tiles_missing = 0;
            }
            b->tiles_missing += merged == b->round;
        }
    }
}

static void queue_block(struct film *film, uint32_t block)
{
    struct film_block *b = &film->blocks[block];
    if (b->state == BLOCK_QUEUED) return;
    /* While a block is out nothing is merged into its tiles. */
    assert(b->state == BLOCK_IDLE || b->state == BLOCK_HELD);
    b->state = BLOCK_QUEUED;
    const uint64_t end = (uint64_t)film->ready_first + film->ready_held++;
    film->ready[end % film->block_count] = block;
}

/* Updates the blocks of a tile that has got more passes than `before`. They may have come a round
 * further. */
static void tell_blocks(struct film *film, uint32_t tile, uint32_t before)
{
    const bool reached = film->tiles[tile].merged == film->tiles[tile].goal;
    struct rect around = film_blocks_of(film, tile);
    for (int32_t row = around.y0; row < around.y1; row++) {
        for (int32_t column = around.x0; column < around.x1; column++) {
            const uint32_t block = film_block_at(film, column, row);
            struct film_block *b = &film->blocks[block];
            if (film->more) {
                if (reached && --b->tiles_missing == 0) queue_block(film, block);
            } else if (before == b->round && --b->tiles_missing == 0) {
                begin_round(film, block);
                queue_block(film, block);
            } else if (b->state == BLOCK_HELD) {
                queue_block(film, block);
            }
        }
    }
}

static void merge(struct film *film, struct film_tile *t, struct samples *samples,
                  struct pass_counts counts)
{
    if (t->merged == 0) {
        t->samples = samples;
    } else {
        passes_add(t->samples, t->counts, samples, counts);
        film->bytes -= samples_bytes(samples);
        samples_destroy(&samples);
    }
    pass_counts_add(&t->counts, &counts);
    t->merged++;
}

static int put_aside(struct film *film, struct film_tile *t, struct samples *samples,
                     struct pass_counts counts)
{
    struct pending_pass *p = calloc(1, sizeof *p);
    if (!p) return ERR_MEMORY;
    p->samples = samples;
    p->counts = counts;
    if (t->last)
        t->last->next = p;
    else
        t->pending = p;
    t->last = p;
    film->pending++;
    return 0;
}

int film_land_pass(struct film *film, uint32_t tile, const struct plan_pass *pass,
                   struct samples *samples)
{
    const struct pass_counts counts = pass_counts_of(pass);
    if (tile >= film->tile_count) return ERR_RANGE;
    struct film_tile *t = &film->tiles[tile];
    if (pass->number < t->landed) return ERR_EXISTS;
    if (pass->number > t->landed || pass->number >= t->goal) return ERR_RANGE;
    if (!fits(film, tile, pass->number, samples)) return ERR_MISMATCH;
    const bool must_wait = t->readers > 0;
    if (must_wait && put_aside(film, t, samples, counts) != 0) return ERR_MEMORY;
    t->landed++;
    film->bytes += samples_bytes(samples);
    if (must_wait) return 0;
    merge(film, t, samples, counts);
    tell_blocks(film, tile, pass->number);
    return 0;
}

int film_land(struct film *film, uint32_t tile, uint32_t pass, struct samples *samples)
{
    const struct plan_pass scheduled = plan_scheduled_pass(film->plan, pass);
    return film_land_pass(film, tile, &scheduled, samples);
}

/* Tiles of a block that are short of their goals. */
static uint32_t count_missing(const struct film *film, uint32_t block)
{
    uint32_t missing = 0;
    struct rect t = film_tiles_of(film, block);
    for (int32_t row = t.y0; row < t.y1; row++)
        for (int32_t column = t.x0; column < t.x1; column++) {
            const struct film_tile *tile = &film->tiles[film_tile_at(film, column, row)];
            missing += tile->merged < tile->goal;
        }
    return missing;
}

void film_begin_round(struct film *film, const uint32_t *more_passes)
{
    assert(film->keeps && film_complete(film));
    film->more = true;
    film->rows_done = 0;
    for (uint32_t i = 0; i < film->tile_count; i++) film->tiles[i].goal += more_passes[i];
    for (uint32_t i = 0; i < film->block_count; i++) {
        struct film_block *b = &film->blocks[i];
        b->tiles_missing = count_missing(film, i);
        if (b->tiles_missing == 0) continue;
        b->state = BLOCK_IDLE;
        film->blocks_done--;
    }
}

static bool has_pending(const struct film *film, uint32_t block)
{
    struct rect t = film_tiles_of(film, block);
    for (int32_t row = t.y0; row < t.y1 && film->pending > 0; row++)
        for (int32_t column = t.x0; column < t.x1; column++)
            if (film->tiles[film_tile_at(film, column, row)].pending) return true;
    return false;
}

static void begin_reading(struct film *film, uint32_t tile)
{
    film->tiles[tile].readers++;
}

void film_hold(struct film *film, bool held)
{
    film->held = held;
}

void film_tell_time(struct film *film, uint64_t now_us)
{
    film->now_us = now_us;
}

void film_rest(struct film *film, uint32_t block, uint64_t until_us)
{
    assert(block < film->block_count);
    film->blocks[block].rests_until = until_us;
}

/* Returns whether a block has all samples of this round. */
static bool is_last_time(const struct film *film, const struct film_block *b)
{
    return film->more || b->round == film->pass_count;
}

bool film_next_ready(struct film *film, uint32_t *block)
{
    while (film->ready_held > 0 && !film->held) {
        *block = film->ready[film->ready_first];
        film->ready_first = (film->ready_first + 1) % film->block_count;
        film->ready_held--;
        struct film_block *b = &film->blocks[*block];
        if (film->now_us < b->rests_until && !is_last_time(film, b)) {
            b->state = BLOCK_IDLE;
            continue;
        }
        const bool held = has_pending(film, *block);
        b->state = held ? BLOCK_HELD : BLOCK_OUT;
        if (held) continue;
        each_tile(film, *block, begin_reading);
        return true;
    }
    return false;
}

static void end_reading(struct film *film, uint32_t tile)
{
    struct film_tile *t = &film->tiles[tile];
    if (--t->readers > 0 || !t->pending) return;
    const uint32_t before = t->merged;
    while (t->pending) {
        struct pass_counts counts;
        struct samples *samples = take_pending(film, t, &counts);
        merge(film, t, samples, counts);
    }
    tell_blocks(film, tile, before);
}

static void release(struct film *film, uint32_t tile)
{
    struct film_tile *t = &film->tiles[tile];
    if (--t->blocks_waiting > 0) return;
    film->bytes -= samples_bytes(t->samples);
    samples_destroy(&t->samples);
}

static bool is_row_done(const struct film *film, int32_t row)
{
    for (int32_t column = 0; column < film->columns; column++)
        if (film->blocks[film_block_at(film, column, row)].state != BLOCK_DONE) return false;
    return true;
}

bool film_block_done(struct film *film, uint32_t block)
{
    struct film_block *b = &film->blocks[block];
    assert(block < film->block_count && b->state == BLOCK_OUT);
    const bool last = is_last_time(film, b);
    b->state = last ? BLOCK_DONE : BLOCK_IDLE;
    each_tile(film, block, end_reading);
    if (!last) return false;
    film->blocks_done++;
    while (film->rows_done < film->rows && is_row_done(film, film->rows_done)) film->rows_done++;
    if (!film->keeps) each_tile(film, block, release);
    return true;
}

int32_t film_rows_done(const struct film *film)
{
    const int32_t rows = film->rows_done * film->block_px, height = film->grid.height_px;
    return rows < height ? rows : height;
}

void film_release(struct film *film)
{
    assert(film_complete(film));
    for (uint32_t i = 0; i < film->tile_count; i++) samples_destroy(&film->tiles[i].samples);
    film->bytes = 0;
}

bool film_complete(const struct film *film)
{
    return film->blocks_done == film->block_count;
}

uint64_t film_bytes(const struct film *film)
{
    return film->bytes;
}

uint64_t film_pending(const struct film *film)
{
    return film->pending;
}
