#include "server/reconstruct/path_error.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Few samples may all have missed what is rare: the pixels around, within AROUND_PX, count as so
 * many more of them. */
#define AROUND_PX     2
#define AROUND_WEIGHT 6.0f

/* Of few samples s may seem to be above 1, and must, for its mean to be right. */
#define Q_MOST 1.2f

/* How many doublings of the passes are believed to go on as they did. */
#define BEYOND 2

/* Of the cell's pixels, those have one share whose spread is of a level, each a factor of four. A
 * level of few pixels tells little by itself: the mean over all counts like LEVEL_PRIOR more. */
#define LEVELS      128
#define LEVEL_PRIOR 8.0

#define SQUARE_MAX 1e37f /* so that sums of sources stay finite */

static size_t patch_index(const struct patch *patch, int32_t x, int32_t y)
{
    return (size_t)(y - patch->rect.y0) * (size_t)rect_width(patch->rect) +
           (size_t)(x - patch->rect.x0);
}

/* Also where sums have overflowed. */
static float bounded(float v)
{
    return v < SQUARE_MAX ? v : SQUARE_MAX;
}

/* What independent samples would have. */
static float independent(const struct patch_paths *p, int c, size_t i)
{
    const float n = p->spp[i];
    return n > 1.0f ? bounded(p->spread[c][i] / (n - 1.0f) / n) : 0.0f;
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
    float low = 0.0f, high = Q_MOST;
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

/* s of n samples, of H of parts of a length: a sequence is as good as its parts, the powers of two
 * that n is the sum of. */
static float stratified(float halves, uint32_t n, float length)
{
    const int power = rounded_log2(length);
    const float q = power > 1 ? decay_of(halves, power) : 1.0f;
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

/* A cell's pixels. */
struct cell {
    struct rect rect;
    float n_least, length; /* samples of a pixel, and of its split parts */
    struct level levels[LEVELS];
    float share[LEVELS]; /* s; below 0: not asked for yet */
    double mean;         /* of H over the pixels' levels */
    /* As of independent samples: as the pixel's spread says, and smoothed. */
    float alone[3][PATH_ERROR_CELL_PX * PATH_ERROR_CELL_PX];
    float smooth[3][PATH_ERROR_CELL_PX * PATH_ERROR_CELL_PX];
};

static size_t cell_index(const struct cell *cell, int32_t x, int32_t y)
{
    return (size_t)(y - cell->rect.y0) * PATH_ERROR_CELL_PX + (size_t)(x - cell->rect.x0);
}

static void load(const struct patch *patch, struct cell *cell)
{
    const struct patch_paths *p = &patch->paths;
    cell->n_least = 1e9f;
    for (int32_t y = cell->rect.y0; y < cell->rect.y1; y++) {
        size_t i = patch_index(patch, cell->rect.x0, y), k = cell_index(cell, cell->rect.x0, y);
        for (int32_t x = cell->rect.x0; x < cell->rect.x1; x++, i++, k++) {
            if (p->spp[i] < cell->n_least) {
                cell->n_least = p->spp[i];
                cell->length = p->split_length[i];
            }
            for (int c = 0; c < 3; c++) cell->alone[c][k] = independent(p, c, i);
        }
    }
}

/* The mean of values over the pixels of the cell around a pixel. */
static float mean_around(const struct cell *cell, const float *values, int32_t x, int32_t y)
{
    const struct rect near = {x - AROUND_PX, y - AROUND_PX, x + AROUND_PX + 1, y + AROUND_PX + 1};
    const struct rect r = rect_intersect(near, cell->rect);
    float sum = 0.0f;
    for (int32_t v = r.y0; v < r.y1; v++)
        for (int32_t u = r.x0; u < r.x1; u++) sum += values[cell_index(cell, u, v)];
    return sum / (float)rect_area(r);
}

static void smooth(const struct patch *patch, struct cell *cell)
{
    for (int32_t y = cell->rect.y0; y < cell->rect.y1; y++)
        for (int32_t x = cell->rect.x0; x < cell->rect.x1; x++) {
            const float own = patch->paths.spp[patch_index(patch, x, y)] - 1.0f;
            const float weight = own / (own + AROUND_WEIGHT);
            const size_t k = cell_index(cell, x, y);
            for (int c = 0; c < 3; c++) {
                const float around = mean_around(cell, cell->alone[c], x, y);
                cell->smooth[c][k] = around + weight * (cell->alone[c][k] - around);
            }
        }
}

/* By the exponent of the smoothed squares. */
static uint32_t level_of(const struct cell *cell, size_t k)
{
    const float sum = cell->smooth[0][k] + cell->smooth[1][k] + cell->smooth[2][k];
    uint32_t bits;
    memcpy(&bits, &sum, sizeof bits);
    return bits >> 24 & (LEVELS - 1);
}

/* A few bright pixels (a lamp's edge) would speak for a whole cell if all were added up. */
static void add_to_levels(const struct patch *patch, struct cell *cell)
{
    const struct patch_paths *p = &patch->paths;
    memset(cell->levels, 0, sizeof cell->levels);
    for (int32_t y = cell->rect.y0; y < cell->rect.y1; y++)
        for (int32_t x = cell->rect.x0; x < cell->rect.x1; x++) {
            const size_t i = patch_index(patch, x, y), k = cell_index(cell, x, y);
            struct level *level = &cell->levels[level_of(cell, k)];
            level->count++;
            for (int c = 0; c < 3; c++) level->alone += (double)cell->alone[c][k];
            if (p->split && p->split_spp[i] > 0.0f)
                level->halves += (double)bounded(p->split[i] / p->split_spp[i] / p->spp[i]);
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
    double sum = 0.0, pixels = 0.0, told;
    for (uint32_t k = 0; k < LEVELS; k++) {
        cell->share[k] = -1.0f;
        if (cell->levels[k].count == 0) continue;
        const double halves = level_halves(cell, k, &told);
        sum += told > 0.0 ? halves * cell->levels[k].count : 0.0;
        pixels += told > 0.0 ? cell->levels[k].count : 0.0;
    }
    cell->mean = pixels > 0.0 ? sum / pixels : 1.0;
}

static float share_of(struct cell *cell, uint32_t k)
{
    double count;
    if (cell->share[k] >= 0.0f) return cell->share[k];
    const double halves = level_halves(cell, k, &count);
    const double all = (count * halves + LEVEL_PRIOR * cell->mean) / (count + LEVEL_PRIOR);
    cell->share[k] = stratified((float)all, (uint32_t)cell->n_least, cell->length);
    return cell->share[k];
}

static void store(const struct patch *patch, struct cell *cell, struct block_squares *out)
{
    for (int32_t y = cell->rect.y0; y < cell->rect.y1; y++) {
        size_t to = block_squares_index(out, cell->rect.x0, y);
        for (int32_t x = cell->rect.x0; x < cell->rect.x1; x++, to++) {
            const size_t k = cell_index(cell, x, y);
            const float share = patch->paths.split ? share_of(cell, level_of(cell, k)) : 1.0f;
            for (int c = 0; c < 3; c++)
                out->square[SOURCE_PATHS][c][to] = share * cell->smooth[c][k];
        }
    }
}

void path_error_find(const struct patch *patch, struct block_squares *out)
{
    const int32_t side = PATH_ERROR_CELL_PX;
    struct cell cell;
    if (!patch->paths.spread[0]) return;
    for (int32_t y = out->rect.y0; y < out->rect.y1; y += side)
        for (int32_t x = out->rect.x0; x < out->rect.x1; x += side) {
            cell.rect = rect_intersect((struct rect){x, y, x + side, y + side}, out->rect);
            load(patch, &cell);
            smooth(patch, &cell);
            add_to_levels(patch, &cell);
            find_mean(&cell);
            store(patch, &cell, out);
        }
}
