#include "server/job/frame/tile_deaths.h"

#include <stdlib.h>

void tile_deaths_fini(struct tile_deaths *d)
{
    free(d->list);
    *d = (struct tile_deaths){0};
}

void tile_deaths_add(struct tile_deaths *d, uint32_t tile, uint64_t worker)
{
    if (tile_deaths_of(d, tile) == 0 && worker != d->last) {
        d->last = worker;
        d->unexpected++;
    }
    if (d->count == d->capacity) {
        const uint32_t capacity = d->capacity ? 2 * d->capacity : 16;
        struct tile_death *list = realloc(d->list, capacity * sizeof *list);
        if (!list) return;
        d->list = list;
        d->capacity = capacity;
    }
    d->list[d->count++] =
        (struct tile_death){.worker = worker, .tile = tile, .before = d->unexpected};
}

uint32_t tile_deaths_of(const struct tile_deaths *d, uint32_t tile)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < d->count; i++) count += d->list[i].tile == tile;
    return count;
}

uint32_t tile_deaths_elsewhere(const struct tile_deaths *d, uint32_t tile)
{
    for (uint32_t i = 0; i < d->count; i++)
        if (d->list[i].tile == tile) return d->unexpected - d->list[i].before;
    return 0;
}

void tile_deaths_clear(struct tile_deaths *d, uint32_t tile)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < d->count; i++)
        if (d->list[i].tile != tile) d->list[kept++] = d->list[i];
    d->count = kept;
}

void tile_deaths_survived(struct tile_deaths *d, uint64_t worker)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < d->count; i++)
        if (d->list[i].worker != worker) d->list[kept++] = d->list[i];
    d->count = kept;
}
