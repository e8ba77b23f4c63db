#include "server/job/frame/tile_order.h"

#include <stdlib.h>

#include "proto/error.h"

/* Tiles that go first: 32 of many, 16 of few, and never more than half of them. */
#define PROBES_BITS   5
#define PROBES        (1u << PROBES_BITS)
#define TILES_A_PROBE 6

struct place {
    uint32_t probe;      /* its place among them; PROBES: none */
    int32_t row, column; /* of the cell */
    int32_t inwards;     /* pixels to the nearer of the cell's upper and left borders */
    uint32_t tile;
};

static int sign(int64_t difference)
{
    return (difference > 0) - (difference < 0);
}

static int compare_places(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    if (p->probe != q->probe) return sign((int64_t)p->probe - q->probe);
    if (p->row != q->row) return sign((int64_t)p->row - q->row);
    if (p->column != q->column) return sign((int64_t)p->column - q->column);
    if (p->inwards != q->inwards) return sign((int64_t)p->inwards - q->inwards);
    return sign((int64_t)p->tile - q->tile);
}

static struct place place_of(const struct tile_grid *grid, int32_t cell_px, uint32_t tile)
{
    const struct rect r = tile_grid_rect(grid, tile);
    const int32_t right = r.x0 % cell_px, down = r.y0 % cell_px;
    return (struct place){.probe = PROBES,
                          .row = r.y0 / cell_px,
                          .column = r.x0 / cell_px,
                          .inwards = right < down ? right : down,
                          .tile = tile};
}

/* Of 2 n probes each n-th part of the height and of the width has two. Bits in reverse make those
 * of the first few lie as evenly as all. */
static void place_probes(const struct tile_grid *grid, struct place *places)
{
    const uint32_t count = tile_grid_count(grid);
    const uint32_t bits = count < TILES_A_PROBE * PROBES ? PROBES_BITS - 1 : PROBES_BITS;
    const int64_t all = INT64_C(1) << bits, half = all / 2;
    for (uint32_t k = 0; k < all && k < count / 2; k++) {
        int64_t at = 0;
        for (uint32_t bit = 0; bit < bits; bit++) at = at << 1 | (k >> bit & 1);
        const int64_t row = at / 2, column = (row * 3 + at % 2 * half / 2) % half;
        const int64_t x = (2 * column + 1) * grid->width_px / all / grid->side_px;
        const int64_t y = (2 * row + 1) * grid->height_px / all / grid->side_px;
        struct place *place = &places[y * grid->columns + x];
        if (place->probe == PROBES) place->probe = k;
    }
}

int tile_order_by_rows(const struct tile_grid *grid, int32_t cell_px, uint32_t *order)
{
    const uint32_t count = tile_grid_count(grid);
    struct place *places = calloc(count, sizeof *places);
    if (!places) return ERR_MEMORY;
    for (uint32_t i = 0; i < count; i++) places[i] = place_of(grid, cell_px, i);
    place_probes(grid, places);
    qsort(places, count, sizeof *places, compare_places);
    for (uint32_t i = 0; i < count; i++) order[i] = places[i].tile;
    free(places);
    return 0;
}

/* A cell or a tile with its squared error. */
struct noisy {
    double error;
    uint32_t index;
};

static int compare_noisy(const void *a, const void *b)
{
    const struct noisy *p = a, *q = b;
    if (p->error != q->error) return p->error > q->error ? -1 : 1;
    return sign((int64_t)p->index - q->index);
}

/* Returns the half-open range of tiles that a cell reads. */
static struct rect tiles_of(const struct tile_grid *grid, struct rect cell, int32_t reach_px)
{
    const struct rect image = {0, 0, grid->width_px, grid->height_px};
    const struct rect rect = rect_intersect(rect_grow(cell, reach_px), image);
    const int32_t side = grid->side_px;
    return (struct rect){rect.x0 / side, rect.y0 / side, (rect.x1 - 1) / side + 1,
                         (rect.y1 - 1) / side + 1};
}

/* Moves the tiles of a range that are not yet in the order, the noisiest first. `left`: errors of
 * those, negative once they are in it. Returns how many. */
static uint32_t move(const struct tile_grid *grid, struct rect range, double *left,
                     struct noisy *room, uint32_t *order)
{
    uint32_t count = 0;
    for (int32_t row = range.y0; row < range.y1; row++)
        for (int32_t column = range.x0; column < range.x1; column++) {
            const uint32_t tile = (uint32_t)(row * grid->columns + column);
            if (left[tile] < 0.0) continue;
            room[count++] = (struct noisy){left[tile], tile};
            left[tile] = -1.0;
        }
    qsort(room, count, sizeof *room, compare_noisy);
    for (uint32_t i = 0; i < count; i++) order[i] = room[i].index;
    return count;
}

/* Adds each tile's error to its cell, and sorts the cells of a grid. */
static void sort_cells(const struct tile_grid *grid, const struct tile_grid *of_cells,
                       const double *errors, struct noisy *cells)
{
    const int32_t side = of_cells->side_px;
    for (uint32_t i = 0; i < tile_grid_count(of_cells); i++) cells[i] = (struct noisy){0.0, i};
    for (uint32_t i = 0; i < tile_grid_count(grid); i++) {
        const struct rect r = tile_grid_rect(grid, i);
        cells[r.y0 / side * of_cells->columns + r.x0 / side].error += errors[i];
    }
    qsort(cells, tile_grid_count(of_cells), sizeof *cells, compare_noisy);
}

int tile_order_by_errors(const struct tile_grid *grid, int32_t cell_px, int32_t reach_px,
                         const double *errors, uint32_t *order)
{
    const struct tile_grid of_cells = {.width_px = grid->width_px,
                                       .height_px = grid->height_px,
                                       .side_px = cell_px,
                                       .columns = (grid->width_px + cell_px - 1) / cell_px,
                                       .rows = (grid->height_px + cell_px - 1) / cell_px};
    const uint32_t tiles = tile_grid_count(grid), count = tile_grid_count(&of_cells);
    struct noisy *cells = calloc(count, sizeof *cells), *room = calloc(tiles, sizeof *room);
    double *left = calloc(tiles, sizeof *left);
    const bool fits = cells && room && left;
    if (fits) {
        sort_cells(grid, &of_cells, errors, cells);
        for (uint32_t i = 0; i < tiles; i++) left[i] = errors[i] > 0.0 ? errors[i] : 0.0;
    }
    for (uint32_t i = 0, end = 0; fits && i < count; i++) {
        const struct rect cell = tile_grid_rect(&of_cells, cells[i].index);
        end += move(grid, tiles_of(grid, cell, reach_px), left, room, order + end);
    }
    free(cells);
    free(room);
    free(left);
    return fits ? 0 : ERR_MEMORY;
}

/* Pixels from `at` to [first, end), squared; both within an image, so that two of them fit. */
static uint64_t square_beyond(int32_t at, int32_t first, int32_t end)
{
    int64_t away = at < first ? (int64_t)first - at : at >= end ? (int64_t)at - end + 1 : 0;
    return (uint64_t)(away * away);
}

#define OUTSIDE_REGION (UINT64_C(1) << 63)

uint64_t tile_order_lead(const struct tile_priority *priority, const struct tile_grid *grid,
                         int32_t cell_px, uint32_t tile)
{
    const struct rect r = tile_grid_rect(grid, tile);
    uint64_t lead = 0;
    if (priority->has_near) {
        const int32_t x = r.x0 / cell_px * cell_px, y = r.y0 / cell_px * cell_px;
        lead = square_beyond(priority->near_x, x, x + cell_px) +
               square_beyond(priority->near_y, y, y + cell_px);
    }
    if (!rect_is_empty(priority->region) && rect_is_empty(rect_intersect(priority->region, r)))
        lead |= OUTSIDE_REGION;
    return lead;
}
