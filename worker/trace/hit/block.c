#include "worker/trace/hit/block.h"

/* Inside the tile: all lanes are alike but for where they are. */
static void init_whole(struct block *b, int32_t x, int32_t y, struct rect tile)
{
    const int32_t width = rect_width(tile), first = (y - tile.y0) * width + (x - tile.x0);
    for (int32_t i = 0; i < LANES; i++) {
        const int32_t across = i % LANES_ACROSS, down = i / LANES_ACROSS;
        b->x_px[i] = x + across;
        b->y_px[i] = y + down;
        b->inside.on[i] = b->kept.on[i] = -1;
        b->element[i] = (uint32_t)(first + down * width + across);
    }
}

void block_init(struct block *b, int32_t x, int32_t y, int32_t width_px, int32_t height_px,
                struct rect tile)
{
    b->whole =
        x >= tile.x0 && y >= tile.y0 && x + LANES_ACROSS <= tile.x1 && y + LANES_ACROSS <= tile.y1;
    if (b->whole) {
        init_whole(b, x, y, tile);
        return;
    }
    for (int i = 0; i < LANES; i++) {
        int32_t px = x + i % LANES_ACROSS, py = y + i / LANES_ACROSS;
        int32_t kept = -((px >= tile.x0) & (px < tile.x1) & (py >= tile.y0) & (py < tile.y1));
        b->x_px[i] = px;
        b->y_px[i] = py;
        b->inside.on[i] = -((px < width_px) & (py < height_px));
        b->kept.on[i] = kept;
        b->element[i] = (uint32_t)(((py - tile.y0) * rect_width(tile) + (px - tile.x0)) & kept);
    }
}
