#pragma once
/* From a tile's narrow planes to a patch's floats: the part of a tile that a patch covers. */
#include "proto/samples.h"
#include "server/film/passes.h"
#include "server/reconstruct/patch/patch.h"

/* `counts` samples a pixel are in the samples.
 *
 * Converts the pixels of `tile` (the samples' place in the image) that lie in the patch; outside
 * its core only what patch.h says. Halves become floats, scales are taken out, sub-sample depths
 * become distances, and where there is no surface the normal is zero. Distances are cut at
 * SURFACE_DISTANCE_MAX, so that their squares stay finite. */
void gather_tile(const struct plan *plan, const struct samples *samples, struct pass_counts counts,
                 struct rect tile, struct patch *patch);
