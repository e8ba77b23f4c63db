#include "server/reconstruct/path_error.h"

#include <math.h>
#include <stdint.h>

/* Few samples may all have missed what is rare: the pixels around, within AROUND_PX, count as so
 * many more of them. */
#define AROUND_PX     2
#define AROUND_WEIGHT 6.0f

/* Of few samples s may seem to be above 1, and must, for its mean to be right. */
#define Q_MOST 1.2f

/* How many doublings of the passes are believed to go on as they did. */
#define BEYOND 2

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

/* A cell's pixels. */
struct cell {
    struct rect rect;
    float n_least, length; /* samples of a pixel, and of its split parts */
    float share;           /* s */
    float alone[3][PATH_ERROR_CELL_PX * PATH_ERROR_CELL_PX]; /* as of independent samples */
};

static size_t cell_index(const struct cell *cell, int32_t x, int32_t y)
{
    return (size_t)(y - cell->rect.y0) * PATH_ERROR_CELL_PX + (size_t)(x - cell->rect.x0);
}

static void load(const struct patch *patch, struct cell *cell)
{
    const struct patch_paths *p = &patch->paths;
    double alone = 0.0, halves = 0.0;
    cell->n_least = 1e9f;
    for (int32_t y = cell->rect.y0; y < cell->rect.y1; y++) {
        size_t i = patch_index(patch, cell->rect.x0, y), k = cell_index(cell, cell->rect.x0, y);
        for (int32_t x = cell->rect.x0; x < cell->rect.x1; x++, i++, k++) {
            const float n = p->spp[i];
            if (n < cell->n_least) {
                cell->n_least = n;
                cell->length = p->split_length[i];
            }
            for (int c = 0; c < 3; c++) {
                cell->alone[c][k] = independent(p, c, i);
                alone += (double)cell->alone[c][k];
            }
            if (p->split && p->split_spp[i] > 0.0f)
                halves += (double)bounded(p->split[i] / p->split_spp[i] / n);
        }
    }
    const bool told = p->split && alone > 0.0;
    cell->share =
        told ? stratified((float)fmin(halves / alone, 2.0), (uint32_t)cell->n_least, cell->length)
             : 1.0f;
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

static void store(const struct patch *patch, const struct cell *cell, struct block_squares *out)
{
    for (int32_t y = cell->rect.y0; y < cell->rect.y1; y++) {
        size_t i = patch_index(patch, cell->rect.x0, y);
        size_t to = block_squares_index(out, cell->rect.x0, y);
        for (int32_t x = cell->rect.x0; x < cell->rect.x1; x++, i++, to++) {
            const float own = patch->paths.spp[i] - 1.0f, weight = own / (own + AROUND_WEIGHT);
            for (int c = 0; c < 3; c++) {
                const float alone = cell->alone[c][cell_index(cell, x, y)];
                const float around = mean_around(cell, cell->alone[c], x, y);
                out->square[SOURCE_PATHS][c][to] =
                    cell->share * (around + weight * (alone - around));
            }
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
            store(patch, &cell, out);
        }
}
