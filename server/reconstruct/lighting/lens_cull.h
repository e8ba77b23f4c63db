#pragma once
/* Which lens samples the filter of a block reads. It reads what lies near enough to its pixels:
 * samples of pixels farther away only if their slope takes them there. */
#include <stdbool.h>

#include "proto/lens_pattern.h"
#include "proto/tile.h"
#include "server/reconstruct/lens/lens_layer.h"

#define LENS_CULL_PX 128 /* no filter reads farther */

struct lens_cull {
    struct rect near;              /* pixels all of whose samples are read */
    float least[LENS_CULL_PX + 1]; /* slopes below are not read so many pixels from there */
    float around[LENS_LAYERS];     /* samples that lie farther from there are not */
};

void lens_cull_init(const struct plan *plan, struct rect block, struct rect seen,
                    struct lens_cull *out);

/* How far from `near` samples of slopes up to `most` are read. */
int32_t lens_cull_reach_px(const struct lens_cull *c, float most);

/* Pixels from column x on of a row that is `down` away from `near`: least[] of each. */
void lens_cull_row(const struct lens_cull *c, int32_t x, int32_t down, uint32_t count,
                   float *least);

/* Is a sample read that lies at (x, y)? */
static inline bool lens_cull_reads(const struct lens_cull *c, float slope, float x, float y)
{
    const float around = c->around[lens_layer_of(slope)];
    return x >= (float)c->near.x0 - around && x <= (float)c->near.x1 + around &&
           y >= (float)c->near.y0 - around && y <= (float)c->near.y1 + around;
}

/* How far y is from low .. high - 1. */
static inline int32_t lens_cull_distance(int32_t y, int32_t low, int32_t high)
{
    return y < low ? low - y : y >= high ? y - high + 1 : 0;
}
