#include "worker/trace/block.h"

void block_init(struct block *b, int32_t x, int32_t y, int32_t width_px, int32_t height_px,
                struct rect tile)
{
    b->whole =
        x >= tile.x0 && y >= tile.y0 && x + LANES_ACROSS <= tile.x1 && y + LANES_ACROSS <= tile.y1;
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
