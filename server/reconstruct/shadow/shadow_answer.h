#pragma once
/* Which filter answers for which pixels of a block, and how answers are joined: windows along edges
 * where few pixels lie between light and shadow (edge.h), the sheared filter for what they leave,
 * the axis-aligned one instead of it as the light sinks below the horizon; or the axis-aligned one
 * for all. */
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/shadow/receiver.h"
#include "server/reconstruct/shadow/shadow_kernels.h"

/* One light over one block. Arrays are of inner pixels, row by row. */
struct shadow_block {
    const struct plan *plan;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    struct receiver_light light;
    struct rect inner;
    float *seen;       /* -1: the pixel's own value stands */
    float *width;      /* pixels; 0: not filtered */
    float *unoccluded; /* E without occlusion */
    float *sunk; /* how much of the axis-aligned filter's answer there is in the sheared one's, for
                    which what has sunk counts as seen, and for as much as the rest */
};

static inline size_t shadow_block_pixel(const struct shadow_block *s, int32_t x, int32_t y)
{
    return (size_t)(y - s->inner.y0) * (size_t)rect_width(s->inner) + (size_t)(x - s->inner.x0);
}

/* Pixels that the passes of a filter, which is not SHADOW_FILTER_NONE, read around a pixel, but for
 * the filling of slopes. */
int32_t shadow_reach_px(uint32_t filter);

/* Sets seen and width of all that has a wedge in `shaded`, a part of `inner` that is not empty;
 * others stay as they are. ERR_MEMORY. */
int shadow_answer(const struct shadow_block *block, struct rect shaded);
