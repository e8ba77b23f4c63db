#pragma once
/* Composes an image's channels from resolved pixels and samples. */
#include "server/image/image.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "server/reconstruct/compose/block_variance.h"
#include "server/reconstruct/compose/resolve.h"

/* Writes the channels that light, albedo and anti-aliasing make, of `block`:
 *   R G B A      emission + direct + indirect, seen; the share of samples that hit a surface
 *   direct, indirect, emission, albedo   with albedo where it is light; mean over the samples
 *   diffuse_direct, diffuse_indirect     the pixel centre's, before albedo
 *   occlusion    share of the hemisphere that is open; 1 without surface
 *   samples      light and bounce rays of the pixel, those of its glossy lobe among them; 0 without
 *                surface
 *   filter_width sigma in pixels, largest over all filters; 0: not filtered
 *
 * If resolver->errors, it sets those variances of the block that its light field has a part in. */
void compose_light_field(const struct resolver *resolver, struct rect block, struct image *image,
                         struct block_variance *variance, struct block_statistics *statistics);

/* Adds what bounce rays of pixel centres bring to a picture of paths that leave it out:
 *   R G B, indirect    diffuse indirect light times albedo and what glossy lobes see times their
 *                      reflectance, anti-aliased
 *   samples            bounce rays and those of the glossy lobe
 * and writes diffuse_indirect (where the plan has indirect planes), occlusion, filter_width. */
void compose_beside_paths(const struct resolver *resolver, struct rect block, struct image *image,
                          struct block_variance *variance, struct block_statistics *statistics);

/* Writes `error` of R G B: the root of the sum over all sources. */
void compose_error(const struct block_variance *variance, struct image *image);

/* Writes the channels that show the pixel's centre alone, whatever makes the picture:
 *   normal, depth, id                    0 without surface
 *   visibility   share of unblocked strata over all lights with area; 1 where there is no such
 *                light, 0 without surface
 *   slope_min, slope_max                 of the first light with area */
void compose_centre(const struct plan *plan, const struct patch *patch, struct rect block,
                    struct image *image);
