#pragma once
/* From where in a scene which parts of the sky are seen: what windows let in. Rays from random
 * places of a coarse grid's cells learn it, once a scene, and light samples of the sky then go
 * where the sky is (sky_guide.h). Whatever is learned changes noise, never the mean.
 *
 * Directions are the world's, in OPENNESS_U x OPENNESS_V bins of the same angles around +y and from
 * it. */
#include <stdbool.h>
#include <stdint.h>

#define OPENNESS_U    32u
#define OPENNESS_V    16u
#define OPENNESS_BINS (OPENNESS_U * OPENNESS_V)

struct openness;
struct render_scene;

/* Nothing is learned yet. NULL: out of memory. */
struct openness *openness_create(const struct render_scene *scene);
void openness_destroy(struct openness **openness);

/* Learns what is not learned yet. Threads that call at once share the work; all return when it is
 * done. The result does not depend on them. */
void openness_learn(struct openness *o);

/* Cells from which little of the sky is seen; others count as open. Both after openness_learn. */
uint32_t openness_cells(const struct openness *o);

/* The part of each bin that is open from a cell, row by row from +y, in [0, 1]. */
const float *openness_of(const struct openness *o, uint32_t cell);

/* Where cells lie: struct openness_grid's number of a place, which is 1 + that of its cell, or 0
 * where it counts as open. Places beyond the grid have that of its rim. */
struct openness_grid {
    float low[3], per_cell[3]; /* (place - low) * per_cell is in cells */
    uint32_t size[3];
    const uint16_t *number; /* x fastest; borrowed */
};
struct openness_grid openness_grid(const struct openness *o);
