#pragma once
/* From resolved pixels and samples to an image's channels. */
#include "server/image/image.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/resolve.h"

/* Writes all channels that the image has, of `block`:
 *   R G B A      emission + direct + indirect, seen; the share of samples that hit a surface
 *   direct, indirect, emission, albedo   with albedo where it is light; mean over the samples
 *   normal, depth, id                    of the pixel's centre; 0 without surface
 *   samples      light and bounce rays of the pixel; 0 without surface
 *   visibility   share of unblocked strata over all lights with area; 1 where there is no such
 *                light, 0 without surface
 *   slope_min, slope_max                 of the first light with area */
void compose_block(const struct resolver *resolver, struct rect block, struct image *image,
                   struct block_statistics *statistics);
