#include "worker/scene/alias_table.h"

#include <stdbool.h>

/* Walks over the items whose weight is at least the average (heavy), or below it (light). */
struct walk {
    alias_weight *weight;
    const void *items;
    double scale; /* weights average 1 */
    uint32_t count;
};

/* Returns the first heavy or light item from i on, or count without one. *found is its weight. */
static uint32_t next_item(const struct walk *w, uint32_t i, bool heavy, double *found)
{
    for (; i < w->count; i++) {
        *found = w->weight(w->items, i) * w->scale;
        if ((*found >= 1.0) == heavy) break;
    }
    return i;
}

/* One sweep without lists (Huebschle-Schneider and Sanders 2022, "Parallel Weighted Random
 * Sampling", section 4.1): a heavy item fills up the cells of light ones until what is left of it
 * is light itself, and is then filled up by the next heavy one. */
void alias_build(alias_weight *weight, const void *items, uint32_t count, double total,
                 struct alias_cell *cells)
{
    const struct walk w = {weight, items, (double)count / total, count};
    double light_weight = 0.0, left = 0.0;
    uint32_t light = next_item(&w, 0, false, &light_weight);
    uint32_t heavy = next_item(&w, 0, true, &left), last = heavy < count ? heavy : light;
    while (heavy < count) {
        last = heavy;
        if (left >= 1.0) {
            if (light == count) break;
            cells[light] = (struct alias_cell){(float)light_weight, heavy};
            left -= 1.0 - light_weight;
            light = next_item(&w, light + 1, false, &light_weight);
            continue;
        }
        double more = 0.0;
        const uint32_t next = next_item(&w, heavy + 1, true, &more);
        if (next == count) break;
        cells[heavy] = (struct alias_cell){(float)left, next};
        left += more - 1.0;
        heavy = next;
    }
    /* Rounding leaves some cells over. They go to the last heavy item, since a light one may weigh
     * 0. */
    for (; light < count; light = next_item(&w, light + 1, false, &light_weight))
        cells[light] = (struct alias_cell){(float)light_weight, last};
    for (; heavy < count; heavy = next_item(&w, heavy + 1, true, &left))
        cells[heavy] = (struct alias_cell){1.0f, heavy};
}
