#pragma once
/* The path tracer's picture: its sums over the samples so far, divided by their number, and light
 * filtered where the plan has the residual filter. */
#include "server/image/image.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "server/reconstruct/compose/block_variance.h"

/* Writes the channels that paths give, of `block`; those whose plane the plan does not have stay as
 * they are.
 *   R G B A         radiance, filtered; the share of samples that meet a surface
 *   direct, indirect, emission, albedo, diffuse_direct, diffuse_indirect   means over the samples
 *   occlusion       share of samples that are open
 *   samples         n, the samples so far
 * Of these diffuse_direct and diffuse_indirect are filtered, too.
 *
 * Means are finite whatever the sums. pixels_background counts pixels of which no sample meets a
 * surface. ERR_MEMORY. */
int paths_compose(const struct plan *plan, const struct patch *patch, struct rect block,
                  struct image *image, struct block_variance *variance,
                  struct block_statistics *statistics);
