#pragma once
/* Soft shadows of one rectangle light from few samples: the factored sheared filter, the
 * axis-aligned filter, and what both stand on (docs/reconstruction.md, from Light fields and the
 * shear to Axis-aligned shadows).
 *
 *   G-buffer, visibility bits, slopes -> receivers (each pixel in the light's coordinates)
 *     -> wedges (slope range, shear, width) -> passes 1a, 1b, 2a, 2b  or  two passes along x, y;
 *        under the sheared filter also: windows along edges where penumbrae span few pixels
 * (edge.h), and the two passes' answer where the light has sunk below the horizon
 *     -> h, the seen fraction of the unoccluded irradiance -> E = E_unoccluded * h
 *
 * The filter is a pure function of its arguments; any thread may call it. All arrays are those of a
 * patch: width * height of its rect, row by row. What it reads around a pixel lies within
 * shadow_halo_px. */
#include "server/reconstruct/patch/patch.h"

struct shadow_statistics {
    uint64_t pixels_filtered; /* with a wedge */
    uint64_t pixels_alone;    /* lit, without a wedge: they keep their own value */
    uint64_t pixels_unlit;    /* the light is below the horizon, behind, or there is no surface */
    uint64_t
        blocks_skipped; /* blocks without any occluded sample in reach, for which no pass ran */
};

/* Returns how many pixels around a block the filter reads, in its passes and to fill slopes. 0 for
 * SHADOW_FILTER_NONE. */
int32_t shadow_halo_px(enum shadow_filter filter);

/* Filters light k of the plan over `inner`, which lies in patch->rect. The patch needs depth,
 * normal, and the light's visibility and slopes. Writes E (plan.h's scalar irradiance, with
 * visibility) and the filter's sigma in pixels (0: not filtered; may be NULL) for the pixels of
 * `inner` into arrays of the patch's size, and adds to *statistics. Constant visibility stays
 * constant to the last bit. Results are finite for any finite input. ERR_MEMORY. */
int shadow_filter(const struct plan *plan, uint32_t light, const struct patch *patch,
                  struct rect inner, float *irradiance, float *width_px,
                  struct shadow_statistics *statistics);
