#pragma once
/* Composes the picture of a plan with lens samples: each pixel's view through all of the lens,
 * filtered as the plan says or averaged. */
#include "server/image/image.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "server/reconstruct/lighting/lighting.h"

/* Writes these channels of `block`:
 *   R G B A       radiance; the share of lens samples that meet a surface
 *   samples       lens samples of the pixel, and paths of its second set
 *   filter_width  sigma in pixels; 0: not filtered
 *
 * and patch->lens_levels if it is not NULL, of samples as they are lit in the picture. With
 * patch->lens_drawn, R G B and filter_width hold the result of the first sets: second sets are
 * mixed in, and nothing is filtered again (statistics->lens is not set). pixels_background counts
 * pixels without a sample that meets a surface. ERR_MEMORY. */
int defocus_compose(const struct plan *plan, const struct patch *patch, struct rect block,
                    struct image *image, struct block_statistics *statistics);

/* Does the same where light fields light the samples, by `lighting` of the pixels of `lit`. It
 * works in place: afterwards the patch holds the samples as they are lit. */
int defocus_compose_lit(const struct plan *plan, struct patch *patch, struct rect block,
                        const struct lighting *lighting, struct rect lit, struct image *image,
                        struct block_statistics *statistics);
