#pragma once
/* Diffuse indirect light from few samples by sheared filtering over the v-plane (Yan et al. 2015,
 * "Fast 4D sheared filtering for interactive rendering of distribution effects", as corrected in
 * docs/reconstruction.md, V-plane filter). A neighbour's sample is reweighted as the ray from the
 * receiver to the same point, which is exact if all reflectors lie at one height. The filter pays
 * where a textured reflector is near.
 *
 *   samples -> slopes: heights of reflectors -> eta, sigma_x
 *     -> 1a, 1b: along the second tangent, strata at their exact shift -> cells of directions
 *     -> 2a: cells to nodes of shifts -> 2b: along the first tangent -> one division
 *
 * Pass 1a is computed at the taps of 1b, so that nothing is stored per shift, and the second walk
 * follows the first row by row. Beside some 200 bytes a pixel of the block and its halo only
 * samples and node sums of 33 rows are kept. The filter is a pure function of its arguments; any
 * thread may call it. Arrays are those of a patch: width * height of its rect, row by row. What it
 * reads around a pixel lies within v_plane_halo_px. */
#include "server/reconstruct/indirect/indirect.h"

/* Returns how many pixels around a block the filter reads; 0 under other filters. */
int32_t v_plane_halo_px(const struct plan *plan);

/* Filters `inner`, which lies in patch->rect. The patch needs depth, normal, id,
 * bounce_distance_min and indirect_strata, traced under a plan of INDIRECT_FILTER_SHEARED. Writes
 * out[c] for the pixels of `inner` (0 where nothing was measured) and the filter's standard
 * deviation in pixels into width_px (may be NULL), and adds to *statistics. Constant radiance stays
 * constant, to the last bit if it is a power of two; results are finite for finite input.
 * ERR_MEMORY, ERR_RANGE. */
int v_plane_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                   float *const out[3], float *width_px, struct indirect_statistics *statistics);
