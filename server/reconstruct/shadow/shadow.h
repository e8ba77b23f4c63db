#pragma once
/* Soft shadows of one rectangle light from few samples: the factored sheared filter, the
 * axis-aligned one, and what both stand on (docs/reconstruction.md, from Light fields and the shear
 * to Axis-aligned shadows).
 *
 *   G-buffer, visibility bits, slopes -> receivers (where each pixel lies as the light sees it)
 *     -> wedges (slope range, shear, width) -> passes 1a, 1b, 2a, 2b  or  two passes along x, y;
 *        sheared and of few pixels: windows along edges (edge.h); sheared where the light has sunk
 *        below the horizon: the two passes' answer instead
 *     -> h, the seen fraction of the unoccluded irradiance -> E = E_unoccluded * h
 *
 * A pure function of its arguments; any thread. All arrays are those of a patch: width * height of
 * its rect, row by row. What the filter reads around a pixel lies within shadow_halo_px. */
#include "server/reconstruct/patch/patch.h"

struct shadow_statistics {
    uint64_t pixels_filtered; /* with a wedge: went through the passes */
    uint64_t pixels_alone;    /* lit, without a wedge: their own value stands */
    uint64_t pixels_unlit;    /* the light is below the horizon, behind, or there is no surface */
    uint64_t blocks_skipped;  /* blocks without any occluded sample in reach: no pass ran */
};

/* Pixels around a block that the filter reads: of its passes, of filling slopes. 0 for
 * SHADOW_FILTER_NONE. */
int32_t shadow_halo_px(enum shadow_filter filter);

/* Filters light k of the plan over `inner`, which lies in patch->rect; the patch needs depth,
 * normal, and the light's visibility and slopes. Writes E (plan.h's scalar irradiance, with
 * visibility) and the filter's width sigma in pixels (0: not filtered; may be NULL) for the pixels
 * of `inner` into arrays of the patch's size, and adds to *statistics. ERR_MEMORY. Constant
 * visibility comes out constant to the last bit; everything is finite for any finite input. */
int shadow_filter(const struct plan *plan, uint32_t light, const struct patch *patch,
                  struct rect inner, float *irradiance, float *width_px,
                  struct shadow_statistics *statistics);
