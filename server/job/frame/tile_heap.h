#pragma once
/* A binary heap of the tiles that wait, with the least key at the top. Its owner has the memory. */
#include <stdint.h>

struct tile_key {
    uint64_t lead, place; /* compared in this order */
    uint32_t tile;
};

struct tile_heap {
    struct tile_key *keys; /* owned by the heap's owner, with room for all that is pushed */
    uint32_t count;
};

static inline int tile_key_before(const struct tile_key *a, const struct tile_key *b)
{
    return a->lead != b->lead ? a->lead < b->lead : a->place < b->place;
}

void tile_heap_push(struct tile_heap *heap, struct tile_key key);
uint32_t tile_heap_pop(struct tile_heap *heap);
/* Restores the order after keys have changed in place. */
void tile_heap_restore(struct tile_heap *heap);
