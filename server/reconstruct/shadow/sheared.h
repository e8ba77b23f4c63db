#pragma once
/* The factored sheared filter (docs/reconstruction.md, Four passes, after Yan et al. 2015): four
 * passes along one axis each, numerators and denominators carried through all of them, one division
 * at the end.
 *
 * Only what some pixel with a wedge can reach goes through a pass: 2b runs for the pixels asked
 * for, 1b and 2a for those on their walks, 1a for those on the walks of these. */
#include "server/reconstruct/shadow/wedge.h"

/* How far outside of the pixels asked for it looks, beside WEDGE_FILL_PX for their slopes. */
#define SHEARED_REACH_PX (2 * SHADOW_REACH_PX)

/* Filters `count` pixels, row by row from the top, which are lit, have a wedge and lie
 * SHEARED_REACH_PX within the receivers' rect; the receivers get slots. seen[k] becomes the seen
 * fraction of pixel k's irradiance, or -1 where no neighbour says anything. ERR_MEMORY. */
int sheared_filter(const struct receiver_light *light, const struct patch *patch,
                   const struct coverage *coverage, const struct shadow_kernels *kernels,
                   struct receivers *receivers, const uint32_t *pixels, uint32_t count,
                   float *seen);
