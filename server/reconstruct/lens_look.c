/* What pixels see of a layer. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/lens_cells.h"

#define TAPS_MOST 1024 /* a disc of 17 cells' radius */

/* A row's pixels of one phase: those that lie in the same place of their cells. */
struct look {
    struct lens_field *f;
    const struct lens_cells *c;
    struct lens_tap taps[TAPS_MOST];
    struct lens_gather gather;
    float share[LENS_GROUPS]; /* of the cells that make up the lens */
    float *sums;              /* of the pixels of a row */
    size_t stride;
};

/* Which part of the lens groups of taps are, at the layer's middle. */
static void find_shares(struct look *look)
{
    const struct lens_cells *c = look->c;
    const float middle = c->fixed ? c->most : fabsf(c->middle);
    const float reach = middle * c->scale * look->f->shape.inradius + 0.5f;
    float all = 0.0f;
    uint32_t tap = 0;
    for (uint32_t g = 0; g < LENS_GROUPS; g++) {
        look->share[g] = 0.0f;
        for (; tap < look->gather.end[g]; tap++) {
            const float in = reach - look->taps[tap].distance;
            look->share[g] += in > 1.0f ? 1.0f : in > 0.0f ? in : 0.0f;
        }
        all += look->share[g];
    }
    for (uint32_t g = 0; g < LENS_GROUPS; g++) look->share[g] /= all; /* the nearest tap is in */
}

/* Taps of one group, after the first n: those that are within the reach of every slope of the
 * layer, or the others. */
static uint32_t add_taps(struct look *look, float px, float py, uint32_t group, bool inner,
                         uint32_t n)
{
    const struct lens_cells *c = look->c;
    const float size = c->scale * look->f->shape.inradius;
    const float most = c->most * size + 0.5f, least = c->least * size - 0.5f;
    const int32_t reach = (int32_t)ceilf(c->most * c->scale) + 1;
    const float sign = c->middle < 0.0f ? -1.0f : 1.0f;
    for (int32_t y = -reach; y <= reach; y++) {
        for (int32_t x = -reach; x <= reach; x++) {
            const float dx = sign * ((float)x + 0.5f - px), dy = sign * ((float)y + 0.5f - py);
            if (lens_shape_group(dx, dy) != group || n == TAPS_MOST) continue;
            const float distance = lens_shape_distance(&look->f->shape, dx, dy);
            if (distance >= most || (distance <= least) != inner) continue;
            look->taps[n].at = y * c->stride + (x & c->phase) * c->columns + (x >> c->fine);
            look->taps[n++].distance = distance;
        }
    }
    return n;
}

/* Cells around that of a pixel whose centre is px cells to the right and py down of the corner of
 * its first cell. */
static void find_taps(struct look *look, float px, float py)
{
    uint32_t n = 0;
    for (uint32_t g = 0; g < LENS_GROUPS; g++) {
        n = add_taps(look, px, py, g, true, n);
        look->gather.inner[g] = n;
        n = add_taps(look, px, py, g, false, n);
        look->gather.end[g] = n;
    }
    find_shares(look);
}

/* Pixel i of the row buffer, which is pixel p of `wide`: the layer under what nearer ones let
 * through. Of quarters of the lens through which nobody looked at it the others tell. */
static void composite(const struct look *look, size_t i, size_t p)
{
    struct lens_field *f = look->f;
    float total[LENS_SUMS] = {0};
    for (size_t g = 0; g < LENS_GROUPS; g++)
        for (size_t k = 0; k < LENS_SUMS; k++)
            total[k] += look->sums[(g * LENS_SUMS + k) * look->stride + i];
    if (!(total[LENS_SUM_SHARE] > 0.0f)) return; /* then there is weight, too */
    for (size_t g = 0; g < LENS_GROUPS; g++) {
        float sum[LENS_SUMS];
        for (size_t k = 0; k < LENS_SUMS; k++)
            sum[k] = look->sums[(g * LENS_SUMS + k) * look->stride + i];
        if (!(sum[LENS_SUM_WEIGHT] > 0.0f)) memcpy(sum, total, sizeof sum);
        const float weight = sum[LENS_SUM_WEIGHT], share = sum[LENS_SUM_SHARE];
        if (!(share > 0.0f)) continue;
        const float through = f->through[g][p], by = through * look->share[g] / weight;
        for (size_t k = 0; k < LENS_LIGHTS; k++) f->light[k][p] += sum[LENS_SUM_LIGHT + k] * by;
        f->share[p] += share * by;
        f->spread[p] += share * by * fabsf(look->c->fixed ? look->c->most : look->c->middle);
        f->through[g][p] = share < weight ? through * (1.0f - share / weight) : 0.0f;
    }
}

/* Is the layer near any of the cells from `column` on? */
static bool is_near(const struct lens_cells *c, int32_t column, int32_t end, int32_t row)
{
    const uint8_t *tiles =
        c->near + (size_t)((row >> 3) - c->tiles.y0) * (size_t)rect_width(c->tiles);
    for (int32_t x = column >> 3; x <= (end - 1) >> 3; x++)
        if (tiles[x - c->tiles.x0]) return true;
    return false;
}

/* Pixels x, x + step, ... of row y. */
static void look_row(struct look *look, int32_t x, int32_t y)
{
    const struct lens_cells *c = look->c;
    const struct rect targets = c->targets;
    const int32_t step = 1 << c->coarse, cells = LENS_LANES << c->fine;
    const int32_t row = y >> c->coarse << c->fine;
    for (int32_t first = x; first < targets.x1; first += LENS_LANES * step) {
        const int32_t column = first >> c->coarse << c->fine;
        const int32_t left = (targets.x1 - first + step - 1) / step;
        const int32_t end = column + cells < c->rect.x1 ? column + cells : c->rect.x1;
        if (!is_near(c, column, end, row)) continue;
        const size_t at = (size_t)(row - c->rect.y0) * (size_t)c->stride +
                          (size_t)((column - c->rect.x0) >> c->fine);
        look->f->kernels->gather(&look->gather, at, LENS_LANES, look->sums, look->stride);
        for (int32_t i = 0; i < LENS_LANES && i < left; i++)
            if (is_near(c, column + (i << c->fine), column + (i << c->fine) + 1, row))
                composite(look, (size_t)i, lens_wide(look->f, first + i * step, y));
    }
}

void lens_cells_look(struct lens_field *f, const struct lens_cells *c)
{
    float sums[LENS_GROUPS * LENS_SUMS * LENS_LANES];
    struct look look = {.f = f, .c = c, .sums = sums, .stride = LENS_LANES};
    const int32_t step = 1 << c->coarse;
    for (int k = 0; k < LENS_CELL_PLANES; k++) look.gather.plane[k] = c->plane[k];
    look.gather.taps = look.taps;
    for (int32_t py = 0; py < step; py++) {
        for (int32_t px = 0; px < step; px++) {
            find_taps(&look, ((float)px + 0.5f) * c->scale, ((float)py + 0.5f) * c->scale);
            for (int32_t y = c->targets.y0 + ((py - c->targets.y0) & (step - 1)); y < c->targets.y1;
                 y += step)
                look_row(&look, c->targets.x0 + ((px - c->targets.x0) & (step - 1)), y);
        }
    }
}
