#pragma once
/* shadow_kernels' sum_slopes, of pixels side by side. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"

#define SLOPES_SIDE    5
#define SLOPES_REACH   (SLOPES_SIDE / 2)
#define SLOPES_COLUMNS (SHADOW_LANES + SLOPES_SIDE - 1) /* that pixels side by side look at */
#define SLOPES_STRIDE  24

/* Neighbours in a row. */
struct slopes_row {
    _Alignas(64) float shown[6][SLOPES_STRIDE]; /* points and normals */
    const float *a, *b;
    float some_a[SLOPES_COLUMNS], some_b[SLOPES_COLUMNS];
    int32_t has_values;
};

/* What pixels side by side look at, and with what they ask. */
struct slopes_group {
    struct slopes_row rows[SLOPES_SIDE];
    float plane_least[SHADOW_LANES], distance_most2[SHADOW_LANES];
};

/* How many pixels of `most` in the list, from the first on, are among SHADOW_LANES in a row. */
static inline uint32_t slopes_count(const uint32_t *pixels, uint32_t most)
{
    uint32_t count = 1;
    while (count < most && pixels[count] > pixels[count - 1] &&
           pixels[count] - pixels[0] < SHADOW_LANES)
        count++;
    return count;
}

/* The `count` neighbours from `from` on. Columns past them have no values. */
static inline void slopes_look(const struct shadow_field *f, size_t from, size_t count,
                               const float *a, const float *b, struct slopes_row *row)
{
    int32_t any = 0;
    row->a = a + from;
    row->b = b + from;
    if (count < SLOPES_COLUMNS) {
        for (size_t i = 0; i < SLOPES_COLUMNS; i++) row->some_a[i] = row->some_b[i] = -1.0f;
        memcpy(row->some_a, row->a, count * sizeof *a);
        memcpy(row->some_b, row->b, count * sizeof *b);
        row->a = row->some_a;
        row->b = row->some_b;
    }
    for (size_t i = 0; i < SLOPES_COLUMNS; i++) any |= !(row->a[i] < 0.0f);
    row->has_values = any;
    lanes_turn(&f->sources[from], count, SLOPES_STRIDE, row->shown[0]);
}

/* All that the `count` pixels from `first` on look at. Lanes past the end ask nothing. */
static inline void slopes_begin(const struct shadow_field *f, size_t first, size_t count,
                                const float *a, const float *b, struct slopes_group *g)
{
    for (ptrdiff_t y = 0; y < SLOPES_SIDE; y++) {
        const ptrdiff_t from = (ptrdiff_t)first + (y - SLOPES_REACH) * f->width - SLOPES_REACH;
        slopes_look(f, (size_t)from, count + SLOPES_SIDE - 1, a, b, &g->rows[y]);
    }
    for (size_t i = 0; i < count; i++) {
        g->plane_least[i] = f->targets[first + i].plane_least;
        g->distance_most2[i] = f->targets[first + i].distance_most2;
    }
}

/* Does pixel i take its neighbour in column `x` of a row? */
static inline __attribute__((always_inline)) int32_t
slopes_takes(const struct slopes_group *g, const struct slopes_row *row, size_t x, size_t i)
{
    const float(*p)[SLOPES_STRIDE] = g->rows[SLOPES_REACH].shown, (*q)[SLOPES_STRIDE] = row->shown;
    const size_t own = i + SLOPES_REACH, k = i + x;
    const struct asker asker = {{p[0][own], p[1][own], p[2][own]},
                                {p[3][own], p[4][own], p[5][own]},
                                g->plane_least[i],
                                g->distance_most2[i]};
    float squared;
    return compatible_point(&asker, q[0][k], q[1][k], q[2][k], q[3][k], q[4][k], q[5][k],
                            &squared) &
           !(row->a[k] < 0.0f);
}

/* How many, sum of a, sum of b. */
static inline void slopes_add(const struct slopes_group *g, float out[3][SHADOW_LANES])
{
    float counts[SHADOW_LANES] = {0}, sums_a[SHADOW_LANES] = {0}, sums_b[SHADOW_LANES] = {0};
    for (int y = 0; y < SLOPES_SIDE; y++) {
        const struct slopes_row *row = &g->rows[y];
        for (size_t x = 0; row->has_values && x < SLOPES_SIDE; x++) {
            for (size_t i = 0; i < SHADOW_LANES; i++) {
                const int32_t taken = slopes_takes(g, row, x, i);
                const float a = row->a[x + i], b = row->b[x + i];
                counts[i] += taken ? 1.0f : 0.0f;
                sums_a[i] += taken ? a : 0.0f;
                sums_b[i] += taken ? b : 0.0f;
            }
        }
    }
    memcpy(out[0], counts, sizeof counts);
    memcpy(out[1], sums_a, sizeof sums_a);
    memcpy(out[2], sums_b, sizeof sums_b);
}

/* Neighbours of pixels side by side are the same but for few: they are turned into arrays once for
 * up to SHADOW_LANES of them. */
static void kernel_sum_slopes(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                              const float *a, const float *b, float *out)
{
    struct slopes_group group = {0};
    float sums[3][SHADOW_LANES];
    for (uint32_t k = 0, n; k < count; k += n) {
        const size_t first = pixels[k];
        n = slopes_count(pixels + k, count - k);
        slopes_begin(f, first, pixels[k + n - 1] - first + 1, a, b, &group);
        slopes_add(&group, sums);
        for (uint32_t i = 0; i < n; i++, out += 3) {
            for (size_t j = 0; j < 3; j++) out[j] = sums[j][pixels[k + i] - first];
        }
    }
}
