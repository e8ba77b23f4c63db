#pragma once
/* Converts the part of a tile that a patch covers, from narrow planes to floats. */
#include "proto/samples.h"
#include "server/film/passes.h"
#include "server/reconstruct/patch/patch.h"

/* Converts the pixels of `tile`, the samples' place in the image, that lie in the patch. Outside
 * its core a patch has only the planes that patch.h names. `counts` is how many samples per pixel
 * the samples hold. Halves become floats, scales are taken out, and sub-sample depths become
 * distances. Without a surface the normal is zero. Distances are cut at SURFACE_DISTANCE_MAX, so
 * that their squares stay finite. */
void gather_tile(const struct plan *plan, const struct samples *samples, struct pass_counts counts,
                 struct rect tile, struct patch *patch);
