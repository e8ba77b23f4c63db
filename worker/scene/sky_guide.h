#pragma once
/* Where light samples of an environment map go: to its bins in proportion to what they send, to the
 * cosine with which a surface receives it, and to how open the scene is towards them. A table of
 * the bins for each of 26 normals and each cell of the scene's openness. Tables are part of the
 * samples' density, so that pictures do not depend on what they hold in the mean.
 *
 * Normals, places and directions are the world's. */
#include "proto/plan.h"
#include "worker/scene/environment.h"
#include "worker/scene/openness.h"

#define SKY_GUIDE_NORMALS 27u /* by the sign of each component; the middle one is never met */

/* Probabilities are whole multiples of 1 / SKY_GUIDE_UNITS. */
#define SKY_GUIDE_UNITS 32768u

struct sky_guide {
    float cosine, sine; /* of the map's rotation, from the world to the map */
    const struct openness_grid *grid;
    const uint16_t *number; /* one a cell; both the openness's */
    const uint16_t *tables; /* ENVIRONMENT_BINS a table: units of all bins before */
};

/* What a scene knows of its skies. Threads share it. */
struct sky_guides;

/* `scene` is borrowed. NULL: out of memory. */
struct sky_guides *sky_guides_create(const struct render_scene *scene);
void sky_guides_destroy(struct sky_guides **guides);

/* Returns the guide of a map turned as the plan says, learns and makes it where it is not there
 * yet; sky_guides_give gives it back. NULL: out of memory. */
const struct sky_guide *sky_guides_take(struct sky_guides *guides, const struct environment *map,
                                        const struct plan_environment *plan);
void sky_guides_give(struct sky_guides *guides, const struct sky_guide *guide);

/* A guide without a scene: everything is open. NULL: out of memory. */
struct sky_guide *sky_guide_create(const struct environment *map,
                                   const struct plan_environment *plan, const struct openness *o);
void sky_guide_destroy(struct sky_guide **guide);

/* The table for a surface. */
static inline uint32_t sky_guide_table(const struct sky_guide *g, float x, float y, float z,
                                       const float normal[3])
{
    const float n[3] = {g->cosine * normal[0] + g->sine * normal[2], normal[1],
                        g->cosine * normal[2] - g->sine * normal[0]};
    uint32_t facing = 0;
    for (int k = 0; k < 3; k++) facing = 3 * facing + (n[k] > 0.35f ? 2u : n[k] < -0.35f ? 0u : 1u);
    const uint32_t number = g->number[openness_grid_cell(g->grid, (const float[3]){x, y, z})];
    return number * SKY_GUIDE_NORMALS + facing;
}

/* The probability of a bin. */
static inline float sky_guide_probability(const struct sky_guide *g, uint32_t table, uint32_t bin)
{
    const uint16_t *t = g->tables + (size_t)table * ENVIRONMENT_BINS;
    const uint32_t end = bin + 1 < ENVIRONMENT_BINS ? t[bin + 1] : SKY_GUIDE_UNITS;
    return (float)(end - t[bin]) * (1.0f / (float)SKY_GUIDE_UNITS);
}

/* The bin that `choice` in [0, 1) takes, which becomes the place in it. */
static inline uint32_t sky_guide_choose(const struct sky_guide *g, uint32_t table, float *choice)
{
    const uint16_t *t = g->tables + (size_t)table * ENVIRONMENT_BINS;
    const float units = *choice * (float)SKY_GUIDE_UNITS;
    const uint32_t whole = (uint32_t)units;
    uint32_t bin = 0;
    for (uint32_t step = ENVIRONMENT_BINS / 2; step > 0; step /= 2)
        bin += t[bin + step] <= whole ? step : 0;
    const uint32_t end = bin + 1 < ENVIRONMENT_BINS ? t[bin + 1] : SKY_GUIDE_UNITS;
    *choice = (units - (float)t[bin]) / (float)(end - t[bin]);
    return bin;
}
