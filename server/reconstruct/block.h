#pragma once
/* One block from samples to pixels: under a plan with paths the mean of their sums, else the light
 * field's lighting (filtered or not), composition with albedo, anti-aliased resolve. A pure
 * function of its arguments; any thread. */
#include "server/image/image.h"
#include "server/reconstruct/patch.h"

#define BLOCK_SIDE_PX 64

struct block_statistics {
    uint64_t sub_samples_unmatched; /* sub-samples whose surface no pixel around them shows */
    uint64_t pixels_background;     /* no sample shows a surface */
};

/* Pixels around a block that its reconstruction reads under this plan. */
int32_t block_halo_px(const struct plan *plan);

/* Writes `block` (inside patch->rect, which is block grown by the halo and cut at the image) of
 * every channel that `image` has. `layers` as in proto/job.h. */
int block_reconstruct(const struct plan *plan, const struct patch *patch, struct rect block,
                      struct image *image, struct block_statistics *statistics);
