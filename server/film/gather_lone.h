#pragma once
/* Collects the lone sub-samples of a patch from the lists of tiles. Only pixels of its core have
 * sub-samples. */
#include "proto/samples.h"
#include "server/reconstruct/patch/patch.h"

/* Reserves room for `count` entries in the patch's scratch; patch_destroy gives it back. 0 reserves
 * none. ERR_MEMORY. */
int gather_lone_reserve(const struct plan *plan, uint32_t count, struct patch *patch);

/* Returns how many entries of a tile lie in the core. */
uint32_t gather_lone_count(const struct plan *plan, const struct samples *samples, struct rect tile,
                           const struct patch *patch);

/* Adds the entries of `tile` that lie in the core. There must be room for them. */
void gather_lone_tile(const struct plan *plan, const struct samples *samples, struct rect tile,
                      struct patch *patch);
