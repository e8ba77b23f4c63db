#pragma once
/* shadow_kernels' sum_slopes, of pixels side by side. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/lanes_inline.h"

#define SLOPES_SIDE    5
#define SLOPES_REACH   (SLOPES_SIDE / 2)
#define SLOPES_COLUMNS (SHADOW_LANES + SLOPES_SIDE - 1) /* that pixels side by side look at */

/* Neighbours in a row: where it begins. */
struct slopes_row {
    const float *shown[6]; /* points and normals */
    const float *a, *b;
    int32_t has_values;
};

/* What pixels side by side look at, and with what they ask. */
struct slopes_group {
    struct slopes_row rows[SLOPES_SIDE];
    const float *plane_least, *distance_most2;
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

/* The neighbours from `from` on. */
static inline void slopes_look(const struct shadow_pixels *p, size_t from, const float *a,
                               const float *b, struct slopes_row *row)
{
    int32_t any = 0;
    row->a = a + from;
    row->b = b + from;
    for (int k = 0; k < 3; k++) {
        row->shown[k] = p->point[k] + from;
        row->shown[3 + k] = p->normal[k] + from;
    }
    for (size_t i = 0; i < SLOPES_COLUMNS; i++) any |= !(row->a[i] < 0.0f);
    row->has_values = any;
}

/* All that pixels from `first` on look at. */
static inline void slopes_begin(const struct shadow_field *f, size_t first, const float *a,
                                const float *b, struct slopes_group *g)
{
    const struct shadow_pixels *p = f->pixels;
    for (ptrdiff_t y = 0; y < SLOPES_SIDE; y++) {
        const ptrdiff_t from = (ptrdiff_t)first + (y - SLOPES_REACH) * f->width - SLOPES_REACH;
        slopes_look(p, (size_t)from, a, b, &g->rows[y]);
    }
    g->plane_least = p->plane_least + first;
    g->distance_most2 = p->distance_most2 + first;
}

/* Does pixel i take its neighbour in column `x` of a row? */
LANES_INLINE int32_t slopes_takes(const struct slopes_group *g, const struct slopes_row *row,
                                  size_t x, size_t i)
{
    const float *const *p = g->rows[SLOPES_REACH].shown, *const *q = row->shown;
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
    _Alignas(64) float counts[SHADOW_LANES] = {0}, sums_a[SHADOW_LANES] = {0},
                       sums_b[SHADOW_LANES] = {0};
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

/* Up to SHADOW_LANES pixels side by side at once, the last of which may be none of the list's. */
static void kernel_sum_slopes(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                              const float *a, const float *b, float *out)
{
    struct slopes_group group;
    _Alignas(64) float sums[3][SHADOW_LANES];
    for (uint32_t k = 0, n; k < count; k += n) {
        const size_t first = pixels[k];
        n = slopes_count(pixels + k, count - k);
        slopes_begin(f, first, a, b, &group);
        slopes_add(&group, sums);
        for (uint32_t i = 0; i < n; i++, out += 3) {
            for (size_t j = 0; j < 3; j++) out[j] = sums[j][pixels[k + i] - first];
        }
    }
}
