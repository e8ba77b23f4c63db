#pragma once
/* Mixed pixels (proto/mixed.h) of a picture of paths beside light fields. Few paths estimate badly
 * how much of such a pixel each surface covers. Here the light of a surface is that of pixels near
 * by that show it alone, and its share comes from many samples of geometry. Where the result is
 * farther from the paths' own mean than chance explains, the mean stays. With many paths it always
 * does. Whole paths have more samples there instead (worker/trace/field/edge_pixels.h). */
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/residual/residual.h"

/* Returns how many pixels around a block its mixed pixels take light from; 0 if there are none. */
int32_t mixed_paths_ring_px(const struct plan *plan);

/* Changes picture->radiance of the mixed pixels of `block`; returns how many. The picture has the
 * pixels of the patch's core at least up to that ring, or ends with the image. */
uint64_t mixed_paths_apply(const struct plan *plan, const struct patch *patch, struct rect block,
                           const struct residual_picture *picture);
