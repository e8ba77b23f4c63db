#include "server/film/gather_lone.h"

#include <string.h>

int gather_lone_reserve(const struct plan *plan, uint32_t count, struct patch *patch)
{
    struct lone_share *share = &patch->lone;
    share->parts = lone_parts(plan);
    if (count == 0) return 0;
    share->entries = scratch_take(patch->scratch, count * sizeof *share->entries);
    return share->entries ? 0 : ERR_MEMORY;
}

static void copy_light(const struct sparse_list *list, uint32_t e, struct lone_entry *out)
{
    memset(out->light, 0, sizeof out->light);
    for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
        for (uint32_t c = 0; c < 3; c++) {
            const float *light = lone_values(list, part, c);
            if (light) out->light[part][c] = light[e];
        }
}

/* Finds where entry e of a tile's list lies. Returns false if that is not in the core. */
static bool is_in_core(const struct plan *plan, const struct sparse_list *list, uint32_t e,
                       struct rect tile, const struct patch *patch, int32_t *x, int32_t *y)
{
    const struct rect core = patch->core;
    const uint32_t pixel = list->words[e] / plan->sub_samples, width = (uint32_t)rect_width(tile);
    *x = tile.x0 + (int32_t)(pixel % width);
    *y = tile.y0 + (int32_t)(pixel / width);
    return *x >= core.x0 && *x < core.x1 && *y >= core.y0 && *y < core.y1;
}

uint32_t gather_lone_count(const struct plan *plan, const struct samples *samples, struct rect tile,
                           const struct patch *patch)
{
    const struct sparse_list *list = samples->lone;
    uint32_t count = 0;
    int32_t x, y;
    for (uint32_t e = 0; list && e < list->count; e++)
        count += is_in_core(plan, list, e, tile, patch, &x, &y);
    return count;
}

void gather_lone_tile(const struct plan *plan, const struct samples *samples, struct rect tile,
                      struct patch *patch)
{
    const struct sparse_list *list = samples->lone;
    const uint32_t subs = plan->sub_samples;
    int32_t x, y;
    for (uint32_t e = 0; list && e < list->count; e++) {
        if (!is_in_core(plan, list, e, tile, patch, &x, &y)) continue;
        struct lone_entry *to = &patch->lone.entries[patch->lone.count++];
        to->place = (uint32_t)patch_pixel(patch, x, y) * subs + list->words[e] % subs;
        copy_light(list, e, to);
    }
}
