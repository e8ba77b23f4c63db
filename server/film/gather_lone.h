#pragma once
/* From tiles' lists of lone sub-samples to a patch's: of the pixels of its core, which alone have
 * sub-samples. */
#include "proto/samples.h"
#include "server/reconstruct/patch/patch.h"

/* Room for `count` entries, from the patch's scratch, which patch_destroy gives back; none for 0.
 * ERR_MEMORY. */
int gather_lone_reserve(const struct plan *plan, uint32_t count, struct patch *patch);

/* How many of a tile's lie in the core. */
uint32_t gather_lone_count(const struct plan *plan, const struct samples *samples, struct rect tile,
                           const struct patch *patch);

/* Adds those of `tile` that lie in the core, for which there must be room. */
void gather_lone_tile(const struct plan *plan, const struct samples *samples, struct rect tile,
                      struct patch *patch);
