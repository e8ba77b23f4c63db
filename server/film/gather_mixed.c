#include "server/film/gather_mixed.h"

int gather_mixed_reserve(uint32_t count, struct patch *patch)
{
    struct mixed_share *share = &patch->mixed;
    if (count == 0) return 0;
    const size_t entries_bytes = count * sizeof *share->entries;
    const size_t first_bytes = (size_t)rect_area(patch->rect) * sizeof *share->first;
    share->entries = scratch_take(patch->scratch, entries_bytes + first_bytes);
    if (!share->entries) return ERR_MEMORY;
    share->first = (uint32_t *)(void *)(share->entries + count);
    return 0;
}

static bool is_in(struct rect r, int32_t x, int32_t y)
{
    return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
}

/* Where entry e of a tile's list lies. Returns false unless that is in the core, and its lender in
 * the patch. */
static bool find_pixel(const struct sparse_list *list, uint32_t e, struct rect tile,
                       const struct patch *patch, int32_t *x, int32_t *y)
{
    const uint32_t pixel = list->words[e] / MIXED_SLOTS, slot = list->words[e] % MIXED_SLOTS;
    const uint32_t width = (uint32_t)rect_width(tile);
    *x = tile.x0 + (int32_t)(pixel % width);
    *y = tile.y0 + (int32_t)(pixel / width);
    return is_in(patch->core, *x, *y) &&
           is_in(patch->rect, *x + (int32_t)(slot % 3) - 1, *y + (int32_t)(slot / 3) - 1);
}

uint32_t gather_mixed_count(const struct samples *samples, struct rect tile,
                            const struct patch *patch)
{
    const struct sparse_list *list = samples->mixed;
    uint32_t count = 0;
    int32_t x, y;
    for (uint32_t e = 0; list && e < list->count; e++)
        count += find_pixel(list, e, tile, patch, &x, &y);
    return count;
}

void gather_mixed_tile(const struct samples *samples, struct rect tile, struct patch *patch)
{
    const struct sparse_list *list = samples->mixed;
    int32_t x, y;
    for (uint32_t e = 0; list && e < list->count; e++) {
        if (!find_pixel(list, e, tile, patch, &x, &y)) continue;
        struct mixed_entry *to = &patch->mixed.entries[patch->mixed.count++];
        const bool lobes = list->values > MIXED_REFLECTANCE;
        to->place = (uint32_t)patch_pixel(patch, x, y) * MIXED_SLOTS + list->words[e] % MIXED_SLOTS;
        to->share = sparse_list_numbers(list, MIXED_SHARE)[e];
        for (uint32_t c = 0; c < 3; c++) {
            to->albedo[c] = sparse_list_numbers(list, MIXED_ALBEDO + c)[e];
            to->reflectance[c] = lobes ? sparse_list_numbers(list, MIXED_REFLECTANCE + c)[e] : 0.0f;
        }
    }
}
