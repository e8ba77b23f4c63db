#pragma once
/* Four by four pixels, aligned to the image: one lane each. */
#include <stdbool.h>

#include "proto/tile.h"
#include "worker/shade/lanes.h"

struct block {
    int32_t x_px[LANES], y_px[LANES];
    struct lanes_mask inside; /* the image: traced */
    struct lanes_mask kept;   /* the tile as well: stored and counted */
    uint32_t element[LANES];  /* in the tile's planes, where kept */
    bool whole;               /* all sixteen are kept */
};

/* Sets the block whose top left pixel is (x, y), multiples of 4, in an image of width x height that
 * the tile lies in. */
void block_init(struct block *b, int32_t x, int32_t y, int32_t width_px, int32_t height_px,
                struct rect tile);
