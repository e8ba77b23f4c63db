#pragma once
/* Culls lens samples. The lens filter of a block reads samples near its pixels, and samples of
 * farther pixels only if their slope takes them there. */
#include <stdbool.h>

#include "proto/lens_pattern.h"
#include "proto/tile.h"
#include "server/reconstruct/lens/lens_layer.h"

#define LENS_CULL_PX 128 /* the farthest that a filter reads */

struct lens_cull {
    struct rect near;              /* pixels of which all samples are read */
    float least[LENS_CULL_PX + 1]; /* the least slope that is read, by distance from there */
    float
        around[LENS_LAYERS]; /* the largest distance of a sample's position from there, by layer */
};

void lens_cull_init(const struct plan *plan, struct rect block, struct rect seen,
                    struct lens_cull *out);

/* Returns how far from `near` samples of slopes up to `most` are read. */
int32_t lens_cull_reach_px(const struct lens_cull *c, float most);

/* Fills least[] of `count` pixels from column x on, in a row that is `down` away from `near`. */
void lens_cull_row(const struct lens_cull *c, int32_t x, int32_t down, uint32_t count,
                   float *least);

/* Returns whether a sample at (x, y) is read. */
static inline bool lens_cull_reads(const struct lens_cull *c, float slope, float x, float y)
{
    const float around = c->around[lens_layer_of(slope)];
    return x >= (float)c->near.x0 - around && x <= (float)c->near.x1 + around &&
           y >= (float)c->near.y0 - around && y <= (float)c->near.y1 + around;
}

/* Returns the distance of y from low .. high - 1. */
static inline int32_t lens_cull_distance(int32_t y, int32_t low, int32_t high)
{
    return y < low ? low - y : y >= high ? y - high + 1 : 0;
}
