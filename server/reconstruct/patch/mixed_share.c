#include "server/reconstruct/patch/mixed_share.h"

#include <stdlib.h>
#include <string.h>

static int compare(const void *a, const void *b)
{
    const uint32_t x = ((const struct mixed_entry *)a)->place;
    const uint32_t y = ((const struct mixed_entry *)b)->place;
    return (x > y) - (x < y);
}

void mixed_share_sort(struct mixed_share *share, size_t area)
{
    if (share->count > 1) qsort(share->entries, share->count, sizeof *share->entries, compare);
    if (!share->first) return;
    memset(share->first, 0, area * sizeof *share->first);
    for (uint32_t e = share->count; e > 0; e--) share->first[mixed_share_pixel(share, e - 1)] = e;
}

uint32_t mixed_share_find(const struct mixed_share *share, size_t pixel)
{
    if (share->first) return share->first[pixel] > 0 ? share->first[pixel] - 1 : share->count;
    const uint32_t e = mixed_share_from(share, pixel);
    return e < share->count && mixed_share_pixel(share, e) == pixel ? e : share->count;
}

uint32_t mixed_share_from(const struct mixed_share *share, size_t pixel)
{
    uint32_t first = 0, end = share->count;
    while (first < end) {
        const uint32_t middle = first + (end - first) / 2;
        if (mixed_share_pixel(share, middle) < pixel)
            first = middle + 1;
        else
            end = middle;
    }
    return first;
}
