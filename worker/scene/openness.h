#pragma once
/* From where in a scene which parts of the sky are seen: what windows let in. Rays from random
 * places of a coarse grid's cells learn it, once a scene, and light samples of the sky then go
 * where the sky is (sky_guide.h). Whatever is learned changes noise, never the mean.
 *
 * Directions are the world's, in OPENNESS_U x OPENNESS_V bins of the same angles around +y and from
 * it. */
#include "worker/scene/openness_grid.h"

#define OPENNESS_U    32u
#define OPENNESS_V    16u
#define OPENNESS_BINS (OPENNESS_U * OPENNESS_V)

struct openness;

/* Nothing is learned yet. NULL: out of memory. */
struct openness *openness_create(const struct render_scene *scene);
void openness_destroy(struct openness **openness);

/* Learns what is not learned yet. Threads that call at once share the work; all return when it is
 * done. The result does not depend on them. */
void openness_learn(struct openness *o);

/* Cells from which little of the sky is seen; others count as open. All that follows is only to be
 * asked after openness_learn. */
uint32_t openness_cells(const struct openness *o);

/* The part of each bin that is open from a cell, row by row from +y, in [0, 1]. */
const float *openness_of(const struct openness *o, uint32_t cell);

/* Where cells lie. */
const struct openness_grid *openness_grid(const struct openness *o);

/* One a cell of the grid: 1 + that cell's number among those that count, or 0 where it is open. */
const uint16_t *openness_numbers(const struct openness *o);
