#pragma once
/* A floor under rectangle lights with a shelf between them, for tests of what filters make of it:
 * every sample is computed from its place, as a worker would trace it. */
#include <stdint.h>

#include "proto/half.h"
#include "proto/octahedron.h"
#include "proto/samples.h"

/* The shelf is the part of the plane y = height with |x| <= half and z <= 0. */
struct filtered_world {
    float shelf_height, shelf_half; /* half 0: there is none */
};

/* Looks down on the floor y = 0; it ends left of x = -4, where there is nothing. Of `lights`, at
 * most 4, those with an odd number are points. */
void filtered_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                   uint32_t filter, uint32_t lights);

/* Fills a place of a tile; `world` is a struct filtered_world. */
void filtered_put(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t i,
                  const void *world);

/* Owned by the caller; NULL on failed allocation. */
struct samples *filtered_tile(const struct plan *plan, const struct filtered_world *world,
                              uint32_t tile);
