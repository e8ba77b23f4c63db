#pragma once
/* Collects the mixed pixels of a patch's core from the lists of tiles. */
#include "proto/samples.h"
#include "server/reconstruct/patch/patch.h"

/* Makes room for `count` entries, from the patch's scratch, which patch_destroy gives back; none
 * for 0. ERR_MEMORY. */
int gather_mixed_reserve(uint32_t count, struct patch *patch);

/* Returns how many of a tile's entries lie in the core. */
uint32_t gather_mixed_count(const struct samples *samples, struct rect tile,
                            const struct patch *patch);

/* Adds the entries of `tile` that lie in the core, for which there must be room. An entry whose
 * lender lies outside the image, which no worker should send, is left out. */
void gather_mixed_tile(const struct samples *samples, struct rect tile, struct patch *patch);
