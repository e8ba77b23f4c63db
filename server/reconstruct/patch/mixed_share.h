#pragma once
/* The mixed pixels of a patch (proto/mixed.h), and what each takes of the lighting of the pixels
 * around it. */
#include <stddef.h>

#include "proto/mixed.h"

struct mixed_entry {
    uint32_t place; /* pixel of the patch * MIXED_SLOTS + slot */
    float share, albedo[3], reflectance[3];
};

struct mixed_share {
    uint32_t count;              /* entries, by ascending place once they are all there */
    struct mixed_entry *entries; /* the patch's; NULL: none */
    uint32_t *first; /* each pixel's first entry, plus 1; 0: it is not mixed. NULL: not set up */
};

/* Puts the entries in order, and fills `first`, where it is set, for `area` pixels. */
void mixed_share_sort(struct mixed_share *share, size_t area);

/* Returns a pixel's first entry; share->count: it is not mixed. */
uint32_t mixed_share_find(const struct mixed_share *share, size_t pixel);

/* Returns the first entry of a pixel that is not before `pixel`; share->count: there is none. */
uint32_t mixed_share_from(const struct mixed_share *share, size_t pixel);

static inline size_t mixed_share_pixel(const struct mixed_share *share, uint32_t entry)
{
    return share->entries[entry].place / MIXED_SLOTS;
}
