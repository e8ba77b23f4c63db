#include "server/reconstruct/compose/path_error.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

/* Few samples may all have missed what is rare: the pixels around, within AROUND_PX, count as so
 * many more of them. */
#define AROUND_PX     2
#define AROUND_WEIGHT 6.0f

/* Of few samples s may seem to be above 1, and must, for its mean to be right. */
#define Q_MAX 1.2f

/* How many doublings of the passes are believed to go on as they did. */
#define BEYOND 2

/* Of the cell's pixels, those have one share whose spread is of a level, each a factor of four. A
 * level of few pixels tells little by itself: the mean over all counts like LEVEL_PRIOR more. */
#define LEVELS      128
#define LEVEL_PRIOR 8.0

#define SQUARE_MAX 1e37f /* so that sums of sources stay finite */

/* Also where sums have overflowed. */
static float bounded(float v)
{
    return v < SQUARE_MAX ? v : SQUARE_MAX;
}

/* What independent samples would have. */
static float independent(const struct patch *p, int c, size_t i)
{
    const float n = p->paths.spp[i];
    return n > 1.0f ? bounded(p->path_m2[c][i] / (n - 1.0f) / n) : 0.0f;
}

/* The whole number next to log2. */
static int rounded_log2(float count)
{
    int power = 0;
    for (float most = 1.41421356f; count > most && power < 16; most *= 2.0f) power++;
    return power;
}

/* q of H, by bisection: H grows with it. */
static float decay_of(float halves, int power)
{
    float low = 0.0f, high = Q_MAX;
    for (int i = 0; i < 24; i++) {
        const float q = 0.5f * (low + high);
        float h = 2.0f - q;
        for (int k = 1; k < power; k++) h *= q;
        if (h < halves)
            low = q;
        else
            high = q;
    }
    return high;
}

/* s of n samples of a sequence whose parts have 2^power: it is as good as its parts, the powers of
 * two that n is the sum of. */
static float stratified(float q, uint32_t n, int power)
{
    float sum = 0.0f, part = 1.0f;
    for (int k = 0; k < 32 && n >> k > 0; k++) {
        if (n >> k & 1u) sum += (float)(1u << k) * part;
        if (k < power + BEYOND) part *= q;
    }
    return sum / (float)n;
}

/* Sums over the pixels of one level. */
struct level {
    double alone, halves;
    uint32_t count;
};

/* What a cell's pixels tell. */
struct cell {
    float n_min, length; /* samples of a pixel, and of its split parts */
    struct level levels[LEVELS];
    float decay[LEVELS];  /* q; below 0: not asked for yet */
    float weight[LEVELS]; /* of what the cell says of a level */
    double mean;          /* of H over the pixels' levels */
    double known;         /* share of the pixels that tell something */
};

/* The block's cells and those around it. */
struct field {
    const struct patch *patch;
    struct rect rect, wide; /* the cells' pixels; and those that they are smoothed over */
    struct rect grid;       /* the cells, counted from the image's corner */
    struct cell *cells;     /* row by row */
    float *alone[3];        /* as of independent samples, over `wide` */
    float *smooth[3];       /* the same smoothed, over `rect` */
    float *row;             /* of `wide` */
    void *memory;           /* owned, with `cells` */
};

static size_t index_in(struct rect r, int32_t x, int32_t y)
{
    return (size_t)(y - r.y0) * (size_t)rect_width(r) + (size_t)(x - r.x0);
}

static int field_create(const struct patch *patch, struct rect block, struct field *f)
{
    const int32_t side = PATH_ERROR_CELL_PX;
    const struct rect cells = {block.x0 / side - 1, block.y0 / side - 1, (block.x1 - 1) / side + 2,
                               (block.y1 - 1) / side + 2};
    const struct rect pixels = {cells.x0 * side, cells.y0 * side, cells.x1 * side, cells.y1 * side};
    *f = (struct field){.patch = patch, .rect = rect_intersect(pixels, patch->rect)};
    f->wide = rect_intersect(rect_grow(f->rect, AROUND_PX), patch->rect);
    f->grid = (struct rect){f->rect.x0 / side, f->rect.y0 / side, (f->rect.x1 - 1) / side + 1,
                            (f->rect.y1 - 1) / side + 1};
    const size_t wide = (size_t)rect_area(f->wide), area = (size_t)rect_area(f->rect);
    float *next = malloc((3 * wide + 3 * area + (size_t)rect_width(f->wide)) * sizeof *next);
    f->memory = next;
    f->cells = calloc((size_t)rect_area(f->grid), sizeof *f->cells);
    if (!f->memory || !f->cells) return ERR_MEMORY;
    for (int c = 0; c < 3; c++, next += wide) f->alone[c] = next;
    for (int c = 0; c < 3; c++, next += area) f->smooth[c] = next;
    f->row = next;
    return 0;
}

static void field_fini(struct field *f)
{
    free(f->memory);
    free(f->cells);
}

static struct cell *cell_at(const struct field *f, int32_t column, int32_t row)
{
    return &f->cells[index_in(f->grid, column, row)];
}

static void load(const struct field *f)
{
    const struct patch *patch = f->patch;
    for (int32_t y = f->wide.y0; y < f->wide.y1; y++) {
        size_t i = patch_pixel(patch, f->wide.x0, y), k = index_in(f->wide, f->wide.x0, y);
        for (int32_t x = f->wide.x0; x < f->wide.x1; x++, i++, k++)
            for (int c = 0; c < 3; c++) f->alone[c][k] = independent(patch, c, i);
    }
}

/* Sums over the rows around y, of every column. */
static struct rect sum_rows(const struct field *f, int c, int32_t y)
{
    const struct rect near = {f->wide.x0, y - AROUND_PX, f->wide.x1, y + AROUND_PX + 1};
    const struct rect r = rect_intersect(near, f->wide);
    const size_t width = (size_t)rect_width(r);
    memset(f->row, 0, width * sizeof *f->row);
    for (int32_t v = r.y0; v < r.y1; v++) {
        const float *from = f->alone[c] + index_in(f->wide, r.x0, v);
        for (size_t x = 0; x < width; x++) f->row[x] += from[x];
    }
    return r;
}

/* The mean over the pixels around, mixed with the pixel's own by what its samples weigh. */
static void smooth(const struct field *f, int c)
{
    for (int32_t y = f->rect.y0; y < f->rect.y1; y++) {
        const struct rect r = sum_rows(f, c, y);
        for (int32_t x = f->rect.x0; x < f->rect.x1; x++) {
            const int32_t x0 = x - AROUND_PX > r.x0 ? x - AROUND_PX : r.x0;
            const int32_t x1 = x + AROUND_PX + 1 < r.x1 ? x + AROUND_PX + 1 : r.x1;
            const float own = f->patch->paths.spp[patch_pixel(f->patch, x, y)] - 1.0f;
            const float weight = own / (own + AROUND_WEIGHT);
            float sum = 0.0f;
            for (int32_t u = x0; u < x1; u++) sum += f->row[u - f->wide.x0];
            const float around = sum / (float)((x1 - x0) * rect_height(r));
            f->smooth[c][index_in(f->rect, x, y)] =
                around + weight * (f->alone[c][index_in(f->wide, x, y)] - around);
        }
    }
}

/* By the exponent of the smoothed squares. */
static uint32_t level_of(const struct field *f, size_t k)
{
    const float sum = f->smooth[0][k] + f->smooth[1][k] + f->smooth[2][k];
    uint32_t bits;
    memcpy(&bits, &sum, sizeof bits);
    return bits >> 24 & (LEVELS - 1);
}

/* A few bright pixels (a lamp's edge) would speak for a whole cell if all were added up. */
static void add_to_levels(const struct field *f, struct rect r, struct cell *cell)
{
    const struct patch *p = f->patch;
    cell->n_min = 1e9f;
    for (int32_t y = r.y0; y < r.y1; y++) {
        size_t i = patch_pixel(f->patch, r.x0, y), k = index_in(f->rect, r.x0, y);
        size_t at = index_in(f->wide, r.x0, y);
        for (int32_t x = r.x0; x < r.x1; x++, i++, k++, at++) {
            struct level *level = &cell->levels[level_of(f, k)];
            level->count++;
            for (int c = 0; c < 3; c++) level->alone += (double)f->alone[c][at];
            if (p->path_half_difference2 && p->paths.split_spp[i] > 0.0f)
                level->halves += (double)bounded(p->path_half_difference2[i] /
                                                 p->paths.split_spp[i] / p->paths.spp[i]);
            if (p->paths.spp[i] >= cell->n_min) continue;
            cell->n_min = p->paths.spp[i];
            cell->length = p->paths.split_length[i];
        }
    }
}

/* H of a level and its neighbours; `count` pixels said so. */
static double level_halves(const struct cell *cell, uint32_t k, double *count)
{
    struct level sum = {0};
    for (uint32_t j = k > 0 ? k - 1 : 0; j <= k + 1 && j < LEVELS; j++) {
        sum.alone += cell->levels[j].alone;
        sum.halves += cell->levels[j].halves;
        sum.count += cell->levels[j].count;
    }
    *count = sum.alone > 0.0 ? sum.count : 0.0;
    return sum.alone > 0.0 ? fmin(sum.halves / sum.alone, 2.0) : 0.0;
}

static void find_mean(struct cell *cell)
{
    double sum = 0.0, pixels = 0.0, all = 0.0, told;
    for (uint32_t k = 0; k < LEVELS; k++) {
        cell->decay[k] = -1.0f;
        if (cell->levels[k].count == 0) continue;
        const double halves = level_halves(cell, k, &told);
        sum += told > 0.0 ? halves * cell->levels[k].count : 0.0;
        pixels += told > 0.0 ? cell->levels[k].count : 0.0;
        all += cell->levels[k].count;
    }
    cell->mean = pixels > 0.0 ? sum / pixels : 1.0;
    cell->known = all > 0.0 ? pixels / all : 0.0;
}

static void fill_cells(const struct field *f)
{
    const int32_t side = PATH_ERROR_CELL_PX;
    for (int32_t row = f->grid.y0; row < f->grid.y1; row++)
        for (int32_t column = f->grid.x0; column < f->grid.x1; column++) {
            const int32_t x = column * side, y = row * side;
            struct cell *cell = cell_at(f, column, row);
            add_to_levels(f, rect_intersect((struct rect){x, y, x + side, y + side}, f->rect),
                          cell);
            find_mean(cell);
        }
}

/* Of a level that few of a cell's pixels have, the cell's mean tells. */
static void find_decay(struct cell *cell, uint32_t k)
{
    double count;
    const double halves = level_halves(cell, k, &count);
    const double all = (count * halves + LEVEL_PRIOR * cell->mean) / (count + LEVEL_PRIOR);
    const int power = rounded_log2(cell->length);
    cell->decay[k] = power > 1 ? decay_of((float)all, power) : 1.0f;
    cell->weight[k] = (float)(count + LEVEL_PRIOR * cell->known);
}

static int32_t clamp(int32_t v, int32_t from, int32_t to)
{
    return v < from ? from : v >= to ? to - 1 : v;
}

/* q at a pixel, between the four cells whose middles are around it: a cell's own would show its
 * borders. Cells that know more of the level say more. */
static float decay_at(const struct field *f, int32_t x, int32_t y, uint32_t k)
{
    const int32_t side = PATH_ERROR_CELL_PX, half = side / 2;
    const int32_t left = (x + half) / side - 1, top = (y + half) / side - 1;
    const float u = ((float)(x - left * side - half) + 0.5f) / (float)side;
    const float v = ((float)(y - top * side - half) + 0.5f) / (float)side;
    float sum = 0.0f, weights = 0.0f;
    for (int i = 0; i < 4; i++) {
        struct cell *cell = cell_at(f, clamp(left + (i & 1), f->grid.x0, f->grid.x1),
                                    clamp(top + (i >> 1), f->grid.y0, f->grid.y1));
        if (cell->decay[k] < 0.0f) find_decay(cell, k);
        const float weight = (i & 1 ? u : 1.0f - u) * (i >> 1 ? v : 1.0f - v) * cell->weight[k];
        sum += weight * cell->decay[k];
        weights += weight;
    }
    return weights > 0.0f ? sum / weights : 1.0f;
}

static float share_at(const struct field *f, int32_t x, int32_t y, size_t k)
{
    const struct patch *p = f->patch;
    const size_t i = patch_pixel(f->patch, x, y);
    if (!p->path_half_difference2 || !(p->paths.spp[i] > 1.0f)) return 1.0f;
    return stratified(decay_at(f, x, y, level_of(f, k)), (uint32_t)p->paths.spp[i],
                      rounded_log2(p->paths.split_length[i]));
}

static void store(const struct field *f, struct block_variance *out)
{
    for (int32_t y = out->rect.y0; y < out->rect.y1; y++) {
        size_t to = block_variance_index(out, out->rect.x0, y);
        for (int32_t x = out->rect.x0; x < out->rect.x1; x++, to++) {
            const size_t k = index_in(f->rect, x, y);
            const float share = share_at(f, x, y, k);
            for (int c = 0; c < 3; c++)
                out->by_source[ERROR_SOURCE_PATHS][c][to] = share * f->smooth[c][k];
        }
    }
}

int32_t path_error_halo_px(const struct plan *plan)
{
    return patch_has_far_paths(plan) ? PATH_ERROR_CELL_PX + AROUND_PX : 0;
}

int path_error_find(const struct patch *patch, struct block_variance *out)
{
    struct field f;
    if (!patch->path_m2[0]) return 0;
    const int error = field_create(patch, out->rect, &f);
    if (!error) {
        load(&f);
        for (int c = 0; c < 3; c++) smooth(&f, c);
        fill_cells(&f);
        store(&f, out);
    }
    field_fini(&f);
    return error;
}
