#pragma once
/* Reconstructs one block, from samples to pixels. A path-traced picture is the mean of its sums. A
 * light field is lit (filtered or not), multiplied by albedo and resolved with anti-aliasing. A
 * plan with both adds the light field's indirect light to the paths' picture. The result depends on
 * the arguments alone; any thread may call it. Light fields light lens samples in place:
 * patch->lens_radiance changes, which saves a copy of the largest array. */
#include "server/image/image.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "server/reconstruct/compose/block_variance.h"

/* Returns the side of the blocks that an image is cut into under this plan. It is larger where a
 * filter reads far around each block, as long as patches stay below LIMIT_PATCH_BYTES. Pixels do
 * not depend on it. */
int32_t block_side_px(const struct plan *plan);

/* Returns the bytes of a patch of the smallest possible block with its halo. */
uint64_t block_patch_bytes_min(const struct plan *plan);

/* Returns how many pixels around a block its reconstruction reads under this plan. */
int32_t block_halo_px(const struct plan *plan);

/* Returns how many pixels around a block its patch's core holds, at most block_halo_px. Beyond it
 * filters read only what patch.h says. */
int32_t block_core_px(const struct plan *plan);

/* Variances of every pixel of a block, row by row and by error source, as the mean over R, G and B;
 * and the luminance (Rec. 709). Target rounds choose samples by them. */
struct block_measure {
    float *variance[ERROR_SOURCE_COUNT];
    float *luminance;
};

/* Writes `block` (inside patch->core; patch->rect is block grown by the halo and cut at the image)
 * of every channel that `image` has. `layers` as in proto/job/job.h. */
int block_reconstruct(const struct plan *plan, struct patch *patch, struct rect block,
                      struct image *image, struct block_statistics *statistics);

/* Does the same and fills *measure. The image has the layer beauty. */
int block_reconstruct_measured(const struct plan *plan, struct patch *patch, struct rect block,
                               struct image *image, const struct block_measure *measure,
                               struct block_statistics *statistics);
