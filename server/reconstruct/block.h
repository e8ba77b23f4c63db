#pragma once
/* One block from samples to pixels: under a plan with paths the mean of their sums, else the light
 * field's lighting (filtered or not), composition with albedo, anti-aliased resolve. A pure
 * function of its arguments; any thread. */
#include "server/image/image.h"
#include "server/reconstruct/shadow.h"

struct block_statistics {
    uint64_t sub_samples_unmatched; /* sub-samples whose surface no pixel around them shows */
    uint64_t pixels_background;     /* no sample shows a surface */
    /* Over the lights; pixels beside the block whose light its sub-samples borrow count, too. */
    struct shadow_statistics shadow;
    uint64_t shadow_cpu_us; /* CPU time of filtering shadows */
};

/* Side of the blocks that an image is cut into under this plan: larger where a filter reads far
 * around each. Pixels do not depend on it. */
int32_t block_side_px(const struct plan *plan);

/* Pixels around a block that its reconstruction reads under this plan. */
int32_t block_halo_px(const struct plan *plan);

/* Writes `block` (inside patch->core; patch->rect is block grown by the halo and cut at the image)
 * of every channel that `image` has. `layers` as in proto/job.h. */
int block_reconstruct(const struct plan *plan, const struct patch *patch, struct rect block,
                      struct image *image, struct block_statistics *statistics);
