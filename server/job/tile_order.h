#pragma once
/* The order in which a frame's tiles are given: along a Hilbert curve over cells of the
 * reconstruction's block size, so that blocks complete early and few unfinished ones are held at a
 * time (Hilbert 1891; the turning form is Warren, Hacker's Delight, 16-2); and what somebody who
 * looks wishes to see before that. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/tile.h"

/* A wish is a hint: it changes when a tile is traced, never what comes of it. */
struct tile_wish {
    struct rect region; /* tiles that it touches go first; empty: none */
    bool has_near;      /* then those whose cell is nearest to this pixel */
    int32_t near_x, near_y;
};

/* The tiles in the curve's order. order[count of tiles]. ERR_MEMORY. */
int tile_order_along_curve(const struct tile_grid *grid, int32_t cell_px, uint32_t *order);

/* How far back the wish puts a tile: less goes first. Distances are those of whole cells, so that
 * blocks complete one after the other under a point that moves. Squared, in pixels. */
uint64_t tile_order_lead(const struct tile_wish *wish, const struct tile_grid *grid,
                         int32_t cell_px, uint32_t tile);
