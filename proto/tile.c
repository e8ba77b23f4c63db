#include "proto/tile.h"

#include <assert.h>

#include "proto/error.h"
#include "proto/limits.h"

static int32_t min_i32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t max_i32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

struct rect rect_intersect(struct rect a, struct rect b)
{
    return (struct rect){max_i32(a.x0, b.x0), max_i32(a.y0, b.y0), min_i32(a.x1, b.x1),
                         min_i32(a.y1, b.y1)};
}

bool rect_is_empty(struct rect r)
{
    return r.x1 <= r.x0 || r.y1 <= r.y0;
}

struct rect rect_grow(struct rect r, int32_t by_px)
{
    return (struct rect){r.x0 - by_px, r.y0 - by_px, r.x1 + by_px, r.y1 + by_px};
}

int tile_grid_init(struct tile_grid *g, int32_t width_px, int32_t height_px, int32_t side_px)
{
    if (width_px < 1 || width_px > LIMIT_IMAGE_SIDE_PX) return ERR_RANGE;
    if (height_px < 1 || height_px > LIMIT_IMAGE_SIDE_PX) return ERR_RANGE;
    if ((int64_t)width_px * height_px > LIMIT_IMAGE_PIXELS) return ERR_RANGE;
    if (side_px < LIMIT_TILE_SIDE_MIN_PX || side_px > LIMIT_TILE_SIDE_PX) return ERR_RANGE;
    *g = (struct tile_grid){
        .width_px = width_px,
        .height_px = height_px,
        .side_px = side_px,
        .columns = (width_px + side_px - 1) / side_px,
        .rows = (height_px + side_px - 1) / side_px,
    };
    return ERR_OK;
}

uint32_t tile_grid_count(const struct tile_grid *g)
{
    return (uint32_t)g->columns * (uint32_t)g->rows;
}

struct rect tile_grid_rect(const struct tile_grid *g, uint32_t index)
{
    assert(index < tile_grid_count(g));
    int32_t x0 = (int32_t)(index % (uint32_t)g->columns) * g->side_px;
    int32_t y0 = (int32_t)(index / (uint32_t)g->columns) * g->side_px;
    return (struct rect){x0, y0, min_i32(x0 + g->side_px, g->width_px),
                         min_i32(y0 + g->side_px, g->height_px)};
}
