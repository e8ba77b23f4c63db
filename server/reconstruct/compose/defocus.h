#pragma once
/* The picture of a plan with lens samples: what all of a pixel's points of the lens see, filtered
 * as the plan says or averaged. */
#include "server/image/image.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "server/reconstruct/lighting/lighting.h"

/* Writes, of `block`:
 *   R G B A       radiance; the share of lens samples that meet a surface
 *   samples       lens samples of the pixel, and paths of its second set
 *   filter_width  sigma in pixels; 0: not filtered
 *
 * and patch->lens_levels where somebody asks for it, of samples lit as they are in the picture.
 * Where patch->lens_drawn, R G B and filter_width are those of the first sets before: second sets
 * are mixed into them, and nothing is filtered again (statistics->lens is not set).
 * pixels_background counts pixels of which no sample meets a surface. ERR_MEMORY. */
int defocus_compose(const struct plan *plan, const struct patch *patch, struct rect block,
                    struct image *image, struct block_statistics *statistics);

/* The same where light fields light the samples: by `lighting`, which is of `lit`. In place: the
 * patch has the samples as they are lit afterwards. */
int defocus_compose_lit(const struct plan *plan, struct patch *patch, struct rect block,
                        const struct lighting *lighting, struct rect lit, struct image *image,
                        struct block_statistics *statistics);
