#include "server/job/frame/tile_leases.h"

#include <stddef.h>

void tile_leases_add(struct tile_leases *l, const struct tile_lease *lease)
{
    l->at[l->at[0].generation != 0] = *lease;
}

bool tile_leases_end(struct tile_leases *l, uint64_t worker, uint32_t generation)
{
    for (int i = 0; i < TILE_LEASES; i++) {
        if (l->at[i].generation != generation || l->at[i].worker != worker) continue;
        if (i == 0) l->at[0] = l->at[1];
        l->at[1] = (struct tile_lease){0};
        return true;
    }
    return false;
}

const struct tile_lease *tile_leases_find(const struct tile_leases *l, uint32_t generation)
{
    for (int i = 0; i < TILE_LEASES; i++)
        if (l->at[i].generation == generation) return &l->at[i];
    return NULL;
}
