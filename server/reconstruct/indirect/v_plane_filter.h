#pragma once
/* Diffuse indirect light from few samples by sheared filtering over the v-plane (Yan et al. 2015,
 * "Fast 4D sheared filtering for interactive rendering of distribution effects", as corrected in
 * docs/reconstruction.md, V-plane filter): a neighbour's sample counts as the ray from here to the
 * same place would, as far as what shines lies at one height. Worth its price where a textured
 * reflector is near.
 *
 *   samples -> slopes: heights of what shines -> eta, sigma_x
 *     -> 1a, 1b: along the second tangent, strata at their exact shift -> cells of directions
 *     -> 2a: cells to nodes of shifts -> 2b: along the first tangent -> one division
 *
 * 1a is worked out at the taps of 1b, so that nothing is stored a shift, and the second walk
 * follows the first row by row: beside some 200 bytes a pixel of the block and its halo, samples
 * and node sums of 33 rows. A pure function of its arguments; any thread. Arrays are those of a
 * patch: width * height of its rect, row by row. What the filter reads around a pixel lies within
 * v_plane_halo_px. */
#include "server/reconstruct/indirect/indirect.h"

/* Pixels around a block that the filter reads; 0 under other filters. */
int32_t v_plane_halo_px(const struct plan *plan);

/* Filters `inner`, which lies in patch->rect; the patch needs depth, normal, id, reflector and
 * indirect_strata, traced under a plan of INDIRECT_FILTER_SHEARED. Writes out[c] for the pixels of
 * `inner` (0 where nothing was measured) and the filter's width, its standard deviation in pixels
 * (may be NULL), and adds to *statistics. ERR_MEMORY, ERR_RANGE. Radiance that is the same
 * everywhere stays so, to the last bit where it is a power of two; all is finite for finite input.
 */
int v_plane_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                   float *const out[3], float *width_px, struct indirect_statistics *statistics);
