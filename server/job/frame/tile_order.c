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
