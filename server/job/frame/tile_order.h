#pragma once
/* The order in which a frame's tiles are given. Cells of the reconstruction's block size come row
 * by row from the top. Within a cell tiles go from the borders to earlier cells to the corner that
 * is farthest from them. So rows of the picture end from the top, and are encoded while others are
 * traced. Blocks of unfinished rows hold no more than a band of tiles as wide as the picture; a
 * space-filling curve would hold half as many again. Only the last block waits for the last tiles.
 *
 * Sixteen tiles, 32 of many, or half of a few go before all these, spread over the picture: what
 * they cost tells how long the rest will take (cost_map.h). A tile_priority goes before that order.
 */
#include <stdbool.h>
#include <stdint.h>

#include "proto/tile.h"

/* What should be rendered first. It changes when a tile is traced, and never its samples. */
struct tile_priority {
    struct rect region; /* tiles that it touches go first; empty: none */
    bool has_near;      /* then those whose cell is nearest to this pixel */
    int32_t near_x, near_y;
};

/* Writes the tiles in that order. order[count of tiles]. ERR_MEMORY. */
int tile_order_by_rows(const struct tile_grid *grid, int32_t cell_px, uint32_t *order);

/* Writes another order, for tiles that have been traced before: cells with the greatest errors,
 * summed over their tiles, come first, each with all tiles that it reads within reach_px around it.
 * So these are drawn first, and tell of the others. errors, order[count of tiles]. ERR_MEMORY. */
int tile_order_by_errors(const struct tile_grid *grid, int32_t cell_px, int32_t reach_px,
                         const double *errors, uint32_t *order);

/* Returns how far back the priority puts a tile; less goes first. Distances, squared and in pixels,
 * are those of whole cells, so that blocks complete one after the other under a point that moves.
 */
uint64_t tile_order_lead(const struct tile_priority *priority, const struct tile_grid *grid,
                         int32_t cell_px, uint32_t tile);
