#pragma once
/* One block from samples to pixels: the mean of the paths' sums, or the light field's lighting
 * (filtered or not), composition with albedo, anti-aliased resolve; or, under a plan with both, the
 * sum of the paths' picture and of the light field's indirect light. A function of its arguments
 * alone; any thread. Where light fields light lens samples, these are lit in place:
 * patch->lens_radiance changes, and a second copy of what weighs most is spared. */
#include "server/image/image.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "server/reconstruct/compose/block_variance.h"

/* Side of the blocks that an image is cut into under this plan: larger where a filter reads far
 * around each, as far as their patches stay below LIMIT_PATCH_BYTES. Pixels do not depend on it. */
int32_t block_side_px(const struct plan *plan);

/* Bytes of a patch of the smallest blocks that there are, with all that is around them. */
uint64_t block_patch_bytes_least(const struct plan *plan);

/* Pixels around a block that its reconstruction reads under this plan. */
int32_t block_halo_px(const struct plan *plan);

/* Pixels around a block that its patch's core holds: of those farther out filters read only what
 * patch.h says. At most block_halo_px. */
int32_t block_core_px(const struct plan *plan);

/* Of every pixel of a block, row by row, for whoever decides on more samples: squared standard
 * errors by what would lower them, the mean over R, G and B, and the luminance (Rec. 709). */
struct block_measure {
    float *variance[ERROR_SOURCE_COUNT];
    float *luminance;
};

/* Writes `block` (inside patch->core; patch->rect is block grown by the halo and cut at the image)
 * of every channel that `image` has. `layers` as in proto/job/job.h. */
int block_reconstruct(const struct plan *plan, struct patch *patch, struct rect block,
                      struct image *image, struct block_statistics *statistics);

/* The same, and *measure; the image has the layer beauty. */
int block_reconstruct_measured(const struct plan *plan, struct patch *patch, struct rect block,
                               struct image *image, const struct block_measure *measure,
                               struct block_statistics *statistics);
