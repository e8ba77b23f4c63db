#pragma once
/* The leases of a tile that are in force at the same time: its own and a copy. */
#include <stdbool.h>
#include <stdint.h>

#define TILE_LEASES 2

struct tile_lease {
    uint64_t worker;
    uint32_t generation; /* 0: none */
    bool alone;          /* given as a suspect: to a worker that held nothing else */
};

/* It is empty when zero-initialised. */
struct tile_leases {
    struct tile_lease at[TILE_LEASES];
};

/* Adds the first lease, or else the second. */
void tile_leases_add(struct tile_leases *l, const struct tile_lease *lease);

/* Ends this very lease. Returns false if it is not in force. */
bool tile_leases_end(struct tile_leases *l, uint64_t worker, uint32_t generation);

/* Returns the lease under that generation, or NULL. */
const struct tile_lease *tile_leases_find(const struct tile_leases *l, uint32_t generation);
