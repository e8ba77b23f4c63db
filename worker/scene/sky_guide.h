#pragma once
/* Guides light samples of an environment map by a table of the map's bins (sky_tables.h) for each
 * of 26 normals and each cell of the scene's openness. The tables are part of the samples'
 * density, so the mean of pictures does not depend on them.
 *
 * Normals, places and directions are the world's. */
#include "proto/plan.h"
#include "worker/scene/openness.h"
#include "worker/scene/sky_tables.h"

struct sky_guide {
    float cosine, sine; /* of the map's rotation, from the world to the map */
    const struct openness_grid *grid;
    const uint16_t *number, *pane;  /* one a cell; these are the openness's */
    const float *glazed;            /* openness_glazed */
    uint32_t first_pane, panes;     /* the number before the first pane's; how many there are */
    const struct sky_table *tables; /* SKY_TABLE_NORMALS a number, then a pane */
    struct photons *caustics;       /* of the map's bright parts; NULL: none */
};

/* The guides of a scene's skies. Threads share them. */
struct sky_guides;

/* Creates an empty set of guides. `scene` is borrowed. Returns NULL without memory. */
struct sky_guides *sky_guides_create(const struct render_scene *scene);
void sky_guides_destroy(struct sky_guides **guides);

/* Returns the guide of a map turned as the plan says, and learns and makes it if it is not there
 * yet. sky_guides_give gives it back. Returns NULL without memory. */
const struct sky_guide *sky_guides_take(struct sky_guides *guides, const struct environment *map,
                                        const struct plan_environment *plan);
void sky_guides_give(struct sky_guides *guides, const struct sky_guide *guide);

/* Returns the number of guides, taken or not. */
uint32_t sky_guides_count(struct sky_guides *guides);

/* Creates a guide. `o` has learned and must outlive it; NULL means that all is open. Returns NULL
 * without memory. */
struct sky_guide *sky_guide_create(const struct environment *map,
                                   const struct plan_environment *plan, const struct openness *o);
void sky_guide_destroy(struct sky_guide **guide);

static inline uint32_t sky_guide_numbered(const struct sky_guide *g, uint32_t number,
                                          const float normal[3])
{
    const float n[3] = {g->cosine * normal[0] + g->sine * normal[2], normal[1],
                        g->cosine * normal[2] - g->sine * normal[0]};
    const uint32_t table = number * SKY_TABLE_NORMALS + sky_table_of(n);
    __builtin_prefetch(g->tables[table].heads);
    return table;
}

/* Returns the number of a surface's table and prefetches the table. */
static inline uint32_t sky_guide_table(const struct sky_guide *g, float x, float y, float z,
                                       const float normal[3])
{
    const uint32_t cell = openness_grid_cell(g->grid, (const float[3]){x, y, z});
    return sky_guide_numbered(g, g->number[cell], normal);
}

/* Returns what part of the sky a surface sees through glass, and if that is above 0 sets *table to
 * the number of its table there. */
static inline float sky_guide_glazed(const struct sky_guide *g, const float place[3],
                                     const float normal[3], uint32_t *table)
{
    const uint32_t cell = openness_grid_cell(g->grid, place);
    if (g->glazed[cell] > 0.0f)
        *table = sky_guide_numbered(g, g->first_pane + g->pane[cell], normal);
    return g->glazed[cell];
}
