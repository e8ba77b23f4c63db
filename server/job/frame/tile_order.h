#pragma once
/* The order in which a frame's tiles are given: cells of the reconstruction's block size, row by
 * row from the top, and each from the borders to cells that were before to the corner that is
 * farthest from them. So rows of the picture end from the top, and are encoded while others are
 * traced; the blocks of unfinished rows hold a band of tiles as wide as the picture and no more (a
 * space-filling curve holds half as many again); and what is given last, nothing but the last block
 * waits for. A tile_priority goes before that order. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/tile.h"

/* What is to be rendered first. It changes when a tile is traced, never what comes of it. */
struct tile_priority {
    struct rect region; /* tiles that it touches go first; empty: none */
    bool has_near;      /* then those whose cell is nearest to this pixel */
    int32_t near_x, near_y;
};

/* The tiles in that order. order[count of tiles]. ERR_MEMORY. */
int tile_order_by_rows(const struct tile_grid *grid, int32_t cell_px, uint32_t *order);

/* How far back the priority puts a tile: less goes first. Distances are those of whole cells, so
 * that blocks complete one after the other under a point that moves. Squared, in pixels. */
uint64_t tile_order_lead(const struct tile_priority *priority, const struct tile_grid *grid,
                         int32_t cell_px, uint32_t tile);
