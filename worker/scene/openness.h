#pragma once
/* Learns which parts of the sky are seen from where in a scene, as through windows. Rays from
 * random places of a coarse grid's cells learn it, once per scene, and light samples of the sky
 * then go where the sky is (sky_guide.h). What is learned changes noise, never the mean.
 *
 * Directions are the world's, in OPENNESS_U x OPENNESS_V bins of equal angles around +y and from
 * it. */
#include "worker/scene/openness_grid.h"

#define OPENNESS_U    32u
#define OPENNESS_V    16u
#define OPENNESS_BINS (OPENNESS_U * OPENNESS_V)

struct openness;

/* Creates the openness of a scene, of which nothing is learned yet. Returns NULL without memory. */
struct openness *openness_create(const struct render_scene *scene);
void openness_destroy(struct openness **openness);

/* Learns what is not learned yet. Threads that call at the same time share the work, and all return
 * when it is done. The result does not depend on them. */
void openness_learn(struct openness *o);

/* Returns the number of cells that see little of the sky; others count as open. This function and
 * those below may be called only after openness_learn. */
uint32_t openness_cells(const struct openness *o);

/* Returns the part of each bin that is open from a cell, row by row from +y, in [0, 1]. */
const float *openness_of(const struct openness *o, uint32_t cell);

/* Returns the grid of the cells. */
const struct openness_grid *openness_grid(const struct openness *o);

/* Returns one number for each cell of the grid: 1 + its number among those that count, or 0 where
 * it is open. */
const uint16_t *openness_numbers(const struct openness *o);

/* Where the sky is seen through clear glass, which stops shadow rays: the same as the three
 * functions above, of cells that see enough of it so. Their bins are open through glass alone. */
uint32_t openness_panes(const struct openness *o);
const float *openness_through(const struct openness *o, uint32_t pane);
const uint16_t *openness_pane_numbers(const struct openness *o);

/* Returns, for each cell of the grid, what part of the sky that it sees it sees through glass; 0
 * where that is little. */
const float *openness_glazed(const struct openness *o);
