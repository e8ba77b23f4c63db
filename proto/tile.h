#pragma once
/* Rectangles of pixels, and the grid of tiles over an image. */
#include <stdbool.h>
#include <stdint.h>

/* Half-open: x in [x0, x1), y in [y0, y1); y grows downwards, (0,0) is the top left pixel. */
struct rect {
    int32_t x0, y0, x1, y1;
};

static inline int32_t rect_width(struct rect r)
{
    return r.x1 - r.x0;
}

static inline int32_t rect_height(struct rect r)
{
    return r.y1 - r.y0;
}

static inline int64_t rect_area(struct rect r)
{
    return (int64_t)rect_width(r) * rect_height(r);
}

/* Returns what both have, which may be empty: x1 <= x0 or y1 <= y0. */
struct rect rect_intersect(struct rect a, struct rect b);
bool rect_is_empty(struct rect r);
struct rect rect_grow(struct rect r, int32_t by_px);

/* An image cut into square tiles, the last column and row narrower; row by row from the top left.
 */
struct tile_grid {
    int32_t width_px, height_px, side_px;
    int32_t columns, rows;
};

/* Cuts an image into tiles. ERR_RANGE for sides outside limits.h. */
int tile_grid_init(struct tile_grid *g, int32_t width_px, int32_t height_px, int32_t side_px);
uint32_t tile_grid_count(const struct tile_grid *g);
struct rect tile_grid_rect(const struct tile_grid *g, uint32_t index);
