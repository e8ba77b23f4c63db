#pragma once
/* Finds how much light a pixel may have before it counts as a spike. A spike is a pixel to which
 * one path brought many times the light around. A filter would make a blot of it.
 *
 *   limit = times * mean of min(light, limit) over a square window of linked pixels
 *
 * in two steps, the first without a limit, so that spikes near by hardly raise it. Windows that
 * hold fewer pixels than `times` have no spikes. */
#include <stddef.h>
#include <stdint.h>

#include "proto/tile.h"
#include "server/reconstruct/simd/lanes.h"

/* Arrays of one layout: pixel (x, y) is at origin + (y - rect.y0) * stride + x - rect.x0. Rows have
 * margins of the window's reach and SIMD_LANES. All arrays are finite, and links are 0 wherever
 * there are no two pixels. */
struct spike_limits {
    struct rect rect;
    size_t origin, stride;
    float *light;               /* in: at least 0 */
    float *shown;               /* in: 1 where there is light, else 0 */
    float *link_x, *link_y;     /* in: 1 where a pixel and the next show one smooth surface */
    float *limit;               /* out */
    float *bounded;             /* scratch, as the rest */
    float *along, *along_count; /* sums along x, and what they count */
    float *sum, *count;         /* along y, too */
};
#define SPIKE_ARRAYS 10

/* Assigns the arrays to the struct's pointers, in turn. */
void spike_limits_take(struct spike_limits *s, float *const arrays[SPIKE_ARRAYS]);

/* Finds the limits of the pixels of `rect`. Reads spike_limits_reach(reach_px) pixels around. */
void spike_limits_find(const struct spike_limits *s, struct rect rect, int32_t reach_px,
                       float times);

/* Turns `light` into its means over windows of linked pixels, over `rect`. Leaves the limits. */
void spike_limits_smooth(const struct spike_limits *s, struct rect rect, int32_t reach_px,
                         float *light);

static inline int32_t spike_limits_reach(int32_t reach_px)
{
    return 2 * reach_px;
}

static inline size_t spike_limits_at(const struct spike_limits *s, int32_t x, int32_t y)
{
    return s->origin + (size_t)(y - s->rect.y0) * s->stride + (size_t)(x - s->rect.x0);
}
