#pragma once
/* The factored sheared filter (docs/reconstruction.md, Four passes, after Yan et al. 2015). It runs
 * four passes along one axis each, carries numerators and denominators through all of them, and
 * divides once at the end.
 *
 * A pass runs only for pixels that matter to a pixel with a wedge: 2b for the pixels asked for, 1b
 * and 2a for those on their walks, 1a for those on the walks of these. */
#include "server/reconstruct/shadow/wedge.h"

/* How far around its pixels the filter reads, beside WEDGE_FILL_PX for their slopes. */
#define SHEARED_REACH_PX (2 * SHADOW_REACH_PX)

/* Filters `count` pixels, row by row from the top. They are lit, have a wedge and lie
 * SHEARED_REACH_PX within the receivers' rect; the receivers get slots. seen[k] becomes the seen
 * fraction of pixel k's irradiance, or -1 where it has no tap. ERR_MEMORY. */
int sheared_filter(const struct receiver_light *light, const struct patch *patch,
                   const struct coverage *coverage, const struct shadow_kernels *kernels,
                   struct receivers *receivers, const uint32_t *pixels, uint32_t count,
                   float *seen);
