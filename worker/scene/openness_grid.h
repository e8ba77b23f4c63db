#pragma once
/* A grid of cells over a scene, for what is learned of its places. One box of cells covers the
 * whole scene, and a second one the part where most of its triangles lie close together, so that a
 * room keeps its cells though a wide plane or a dome is around it. Places beyond a box belong to
 * the cells of its rim. */
#include <stdbool.h>
#include <stdint.h>

/* A room is some six cells long, so that windows look different from cell to cell. */
#define OPENNESS_CELLS_MAX 256u

struct render_scene;

struct openness_box {
    float low[3], per_cell[3]; /* (place - low) * per_cell is in cells */
    uint32_t size[3], first;   /* cells along each axis, x fastest; the first one's number */
};

struct openness_grid {
    struct openness_box whole, dense; /* the same where there is one box alone */
    uint32_t cells;                   /* of both boxes */
};

/* Places the boxes. They depend on nothing but the scene. */
void openness_grid_init(struct openness_grid *g, const struct render_scene *scene);

static inline bool openness_box_holds(const struct openness_box *b, const float place[3])
{
    bool holds = true;
    for (int k = 0; k < 3; k++) {
        const float cells = (place[k] - b->low[k]) * b->per_cell[k];
        holds &= cells >= 0.0f && cells <= (float)b->size[k];
    }
    return holds;
}

/* Returns the cell of a place. */
static inline uint32_t openness_grid_cell(const struct openness_grid *g, const float place[3])
{
    const struct openness_box *b = openness_box_holds(&g->dense, place) ? &g->dense : &g->whole;
    uint32_t at[3];
    for (int k = 0; k < 3; k++) {
        const float cells = (place[k] - b->low[k]) * b->per_cell[k];
        const float last = (float)(b->size[k] - 1);
        at[k] = (uint32_t)(cells > 0.0f ? (cells < last ? cells : last) : 0.0f);
    }
    return b->first + (at[2] * b->size[1] + at[1]) * b->size[0] + at[0];
}
