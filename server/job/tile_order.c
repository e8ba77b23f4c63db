#include "server/job/tile_order.h"

#include <stdlib.h>

#include "proto/error.h"

/* Distance along the Hilbert curve of the cell (x, y) in a square of `side` cells, a power of two.
 */
static uint64_t hilbert(uint32_t side, uint32_t x, uint32_t y)
{
    uint64_t d = 0;
    for (uint32_t s = side / 2; s > 0; s /= 2) {
        uint32_t right = (x & s) != 0, down = (y & s) != 0;
        d += (uint64_t)s * s * ((3 * right) ^ down);
        if (down) continue;
        if (right) {
            x = side - 1 - x;
            y = side - 1 - y;
        }
        uint32_t swap = x;
        x = y;
        y = swap;
    }
    return d;
}

struct place {
    uint64_t distance; /* of the cell */
    uint32_t tile;
};

static int compare_places(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
    return (p->tile > q->tile) - (p->tile < q->tile);
}

int tile_order_along_curve(const struct tile_grid *grid, int32_t cell_px, uint32_t *order)
{
    const uint32_t count = tile_grid_count(grid);
    struct place *places = calloc(count, sizeof *places);
    if (!places) return ERR_MEMORY;
    int32_t longest = grid->width_px > grid->height_px ? grid->width_px : grid->height_px;
    uint32_t side = 1;
    while ((int64_t)side * cell_px < longest) side *= 2;
    for (uint32_t i = 0; i < count; i++) {
        struct rect r = tile_grid_rect(grid, i);
        places[i].tile = i;
        places[i].distance = hilbert(side, (uint32_t)(r.x0 / cell_px), (uint32_t)(r.y0 / cell_px));
    }
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

uint64_t tile_order_lead(const struct tile_wish *wish, const struct tile_grid *grid,
                         int32_t cell_px, uint32_t tile)
{
    const struct rect r = tile_grid_rect(grid, tile);
    uint64_t lead = 0;
    if (wish->has_near) {
        const int32_t x = r.x0 / cell_px * cell_px, y = r.y0 / cell_px * cell_px;
        lead = square_beyond(wish->near_x, x, x + cell_px) +
               square_beyond(wish->near_y, y, y + cell_px);
    }
    if (!rect_is_empty(wish->region) && rect_is_empty(rect_intersect(wish->region, r)))
        lead |= OUTSIDE_REGION;
    return lead;
}
