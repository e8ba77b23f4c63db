#pragma once
/* Finds a tile's mixed pixels (proto/mixed.h): those whose centre and one of the eight centres
 * around it, or one of their sub-samples, do not show one surface, and those whose samples differ
 * in colour. It goes by the tile's planes and, for pixels just outside, by the lone finder, so that
 * the result does not depend on the tile. */
#include "worker/trace/field/lone_finder.h"

/* What the centres of a tile's pixels show, and of those around it, row by row, in camera space.
 * distance: 0 without a surface, -1 outside the image. */
struct mixed_cells {
    size_t stride;
    float *point[3], *normal[3], *distance;
    uint32_t *id;      /* surface_sub_id */
    uint8_t *shines;   /* on what may shine */
    uint8_t *apart[4]; /* from the next pixel to the right, and the three below */
};

struct mixed_finder {
    struct lone_finder *lone;
    const struct path_context *context;
    const struct samples *samples;
    struct rect tile;
    struct mixed_cells cells;
    uint8_t
        *edge; /* of the tile's pixels: whether one of the centres around shows another surface */
    uint8_t *mixed; /* whether they are mixed */
    void *memory;   /* owned; kept from tile to tile */
    size_t memory_bytes;
};

/* Frees a finder, which starts as zeros. */
void mixed_finder_fini(struct mixed_finder *f);

/* Looks at a tile whose planes are all filled. `lone` has looked at it, too; all is borrowed.
 * ERR_MEMORY. */
int mixed_finder_look(struct mixed_finder *f, const struct path_context *c,
                      struct lone_finder *lone, const struct samples *samples);

/* Does only the first part, by pixel centres alone: finds pixels at edges. */
int mixed_finder_look_around(struct mixed_finder *f, const struct path_context *c,
                             struct lone_finder *lone, const struct samples *samples);

/* Returns the cell of a pixel of the tile, or beside it. */
static inline size_t mixed_cell(const struct mixed_finder *f, int32_t x, int32_t y)
{
    return (size_t)(y - f->tile.y0 + 1) * f->cells.stride + (size_t)(x - f->tile.x0 + 1);
}

/* Returns whether one of the 3 x 3 centres around shows what may shine. */
bool mixed_is_beside_lamp(const struct mixed_finder *f, int32_t x, int32_t y);

struct shown_surface mixed_surface(const struct mixed_cells *cells, size_t cell);
