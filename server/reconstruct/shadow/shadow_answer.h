#pragma once
/* Chooses the filter of each pixel of a block and joins the answers. Windows along edges serve
 * narrow penumbrae (edge.h), and the sheared filter the rest; as the light sinks below the horizon
 * the axis-aligned filter replaces it. Under SHADOW_FILTER_AXIS_ALIGNED that filter serves all
 * pixels. */
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/shadow/receiver.h"
#include "server/reconstruct/shadow/shadow_kernels.h"

/* One light over one block. Arrays cover the inner pixels, row by row. */
struct shadow_block {
    const struct plan *plan;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    struct receiver_light light;
    struct rect inner;
    float *seen;       /* -1: the pixel keeps its own value */
    float *width;      /* pixels; 0: not filtered */
    float *unoccluded; /* E without occlusion */
    float *sunk; /* share of the axis-aligned filter's answer in place of the sheared one's; the
                    sunk part of the light counts as seen */
};

static inline size_t shadow_block_pixel(const struct shadow_block *s, int32_t x, int32_t y)
{
    return (size_t)(y - s->inner.y0) * (size_t)rect_width(s->inner) + (size_t)(x - s->inner.x0);
}

/* Returns how many pixels the passes of a filter read around a pixel, without the filling of
 * slopes. The filter is not SHADOW_FILTER_NONE. */
int32_t shadow_reach_px(uint32_t filter);

/* Sets seen and width of all pixels with a wedge in `shaded`, a non-empty part of `inner`. Other
 * pixels stay as they are. ERR_MEMORY. */
int shadow_answer(const struct shadow_block *block, struct rect shaded);
