#pragma once
/* The deaths of workers at tiles of a frame. Few are expected, so they are a plain list.
 *
 * A worker whose link broke may come back, or may have been stopped from outside. It has not died
 * of its tiles then. */
#include <stdbool.h>
#include <stdint.h>

struct tile_death {
    uint64_t worker;
    uint32_t tile;
    uint32_t before; /* deaths at other tiles, which nobody suspected */
};

/* It is empty when zero-initialised. */
struct tile_deaths {
    struct tile_death *list; /* owned */
    uint32_t count, capacity;
    uint64_t last;       /* the worker that died last at a tile that nobody suspected */
    uint32_t unexpected; /* such deaths: one a worker, whatever it held */
};

void tile_deaths_fini(struct tile_deaths *d);

/* Notes a death. Without memory it is forgotten, but the tile's returns are counted, too. */
void tile_deaths_add(struct tile_deaths *d, uint32_t tile, uint64_t worker);
/* Returns how many workers died at the tile since it was cleared last. */
uint32_t tile_deaths_of(const struct tile_deaths *d, uint32_t tile);
/* Returns how many have died since the first of these at tiles that nobody suspected: where whole
 * farms are pre-empted, tiles have no part in it. */
uint32_t tile_deaths_elsewhere(const struct tile_deaths *d, uint32_t tile);
void tile_deaths_clear(struct tile_deaths *d, uint32_t tile);
/* Forgets the deaths of a worker, which did not die of its tiles. */
void tile_deaths_survived(struct tile_deaths *d, uint64_t worker);
