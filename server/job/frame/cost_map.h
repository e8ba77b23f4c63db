#pragma once
/* What the tiles of a frame have cost so far, by the part of the picture, and from it what the rest
 * will cost: a sample of the sky costs a tenth of one of glass, and tiles come from the top. */
#include <stdint.h>

#include "proto/tile.h"

#define COST_CELLS 8 /* along each side */

struct cost_cell {
    double due, landed;       /* samples of all its pixels: to come, and here */
    double before;            /* of those here: from rounds that have ended */
    double us;                /* CPU time of those that landed */
    double weight, weight_us; /* the same two, but what landed in earlier rounds counts less */
};

struct cost_map {
    int32_t width_px, height_px;
    struct cost_cell cells[COST_CELLS * COST_CELLS];
};

void cost_map_init(struct cost_map *m, int32_t width_px, int32_t height_px);

/* Begins a round: what is due is forgotten, and what landed counts for a quarter from now on, since
 * later passes are longer and so cost less a sample. */
void cost_map_begin_round(struct cost_map *m);

/* Forgets what is due: tiles are to be noted with all their samples beyond those of the rounds that
 * have ended. */
void cost_map_foresee_anew(struct cost_map *m);

/* Notes samples that a tile is to get, and those that have landed with their CPU time. */
void cost_map_due(struct cost_map *m, struct rect tile, double samples);
void cost_map_land(struct cost_map *m, struct rect tile, double samples, double us);

/* Returns the CPU time of all that has landed, and the samples. */
double cost_map_done_us(const struct cost_map *m);
double cost_map_landed(const struct cost_map *m);

/* Estimates the CPU time of what is due. A cell without samples costs what the others do, the near
 * ones above all. 0 before the first sample. */
double cost_map_left_us(const struct cost_map *m);
