#include "server/reconstruct/patch/lone_share.h"

#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    const uint32_t x = ((const struct lone_entry *)a)->place;
    const uint32_t y = ((const struct lone_entry *)b)->place;
    return (x > y) - (x < y);
}

void lone_share_sort(struct lone_share *share)
{
    if (share->count > 1) qsort(share->entries, share->count, sizeof *share->entries, compare);
}

const struct lone_entry *lone_share_find(const struct lone_share *share, size_t place)
{
    const struct lone_entry *at = share->entries;
    uint32_t left = share->count;
    while (left > 0) {
        const uint32_t half = left / 2;
        if (at[half].place == place) return at + half;
        if (at[half].place < place) {
            at += half + 1;
            left -= half + 1;
        } else {
            left = half;
        }
    }
    return NULL;
}

/* Returns the error of an entry. Two halves a and b of as many samples have the mean (a + b)/2,
 * whose error is |a - b|/2. */
float lone_entry_error(const struct lone_share *share, const struct lone_entry *e,
                       enum lone_part part, enum lone_part half, int channel)
{
    if (!(share->parts >> half & 1u)) return 0.0f;
    return fabsf(e->light[part][channel] - e->light[half][channel]);
}
