#include "server/job/frame/cost_map.h"

void cost_map_init(struct cost_map *m, int32_t width_px, int32_t height_px)
{
    *m = (struct cost_map){.width_px = width_px, .height_px = height_px};
}

/* Returns the cell in which the tile's middle lies. */
static struct cost_cell *cell_of(struct cost_map *m, struct rect tile)
{
    const int64_t x = ((int64_t)tile.x0 + tile.x1) / 2 * COST_CELLS / m->width_px;
    const int64_t y = ((int64_t)tile.y0 + tile.y1) / 2 * COST_CELLS / m->height_px;
    return &m->cells[y * COST_CELLS + x];
}

void cost_map_begin_round(struct cost_map *m)
{
    for (int i = 0; i < COST_CELLS * COST_CELLS; i++) {
        struct cost_cell *cell = &m->cells[i];
        cell->due = 0.0;
        cell->before = cell->landed;
        cell->weight *= 0.25;
        cell->weight_us *= 0.25;
    }
}

void cost_map_foresee_anew(struct cost_map *m)
{
    for (int i = 0; i < COST_CELLS * COST_CELLS; i++)
        m->cells[i].due = m->cells[i].before - m->cells[i].landed;
}

void cost_map_due(struct cost_map *m, struct rect tile, double samples)
{
    cell_of(m, tile)->due += samples;
}

void cost_map_land(struct cost_map *m, struct rect tile, double samples, double us)
{
    struct cost_cell *cell = cell_of(m, tile);
    cell->due = cell->due > samples ? cell->due - samples : 0.0;
    cell->landed += samples;
    cell->us += us;
    cell->weight += samples;
    cell->weight_us += us;
}

double cost_map_done_us(const struct cost_map *m)
{
    double sum = 0.0;
    for (int i = 0; i < COST_CELLS * COST_CELLS; i++) sum += m->cells[i].us;
    return sum;
}

double cost_map_landed(const struct cost_map *m)
{
    double sum = 0.0;
    for (int i = 0; i < COST_CELLS * COST_CELLS; i++) sum += m->cells[i].landed;
    return sum;
}

/* A row is this many columns away: pictures have horizons, and each row has been probed
 * (tile_order.h) when those above it are traced. */
#define ROW_DISTANCE 8

/* The mean over all cells that have samples, weighted by the inverse fourth power of their distance
 * (Shepard 1968), so that the many cells of a sky do not outweigh the near ones. */
static double guess_rate(const struct cost_map *m, int at)
{
    double sum = 0.0, weights = 0.0;
    for (int i = 0; i < COST_CELLS * COST_CELLS; i++) {
        const struct cost_cell *cell = &m->cells[i];
        const int dx = i % COST_CELLS - at % COST_CELLS,
                  dy = (i / COST_CELLS - at / COST_CELLS) * ROW_DISTANCE;
        if (cell->weight <= 0.0) continue;
        const double square = dx * dx + dy * dy, weight = 1.0 / (square * square);
        sum += weight * cell->weight_us / cell->weight;
        weights += weight;
    }
    return weights > 0.0 ? sum / weights : 0.0;
}

double cost_map_left_us(const struct cost_map *m)
{
    double left = 0.0;
    for (int i = 0; i < COST_CELLS * COST_CELLS; i++) {
        const struct cost_cell *cell = &m->cells[i];
        if (cell->due <= 0.0) continue;
        left +=
            cell->due * (cell->weight > 0.0 ? cell->weight_us / cell->weight : guess_rate(m, i));
    }
    return left;
}
