#pragma once
/* v_plane_kernels' walks. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "server/reconstruct/fused.h"
#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/lanes_inline.h"
#include "server/reconstruct/v_plane_kernels.h"

#define V_PLANE_TAPS     (2 * V_PLANE_REACH_PX + 1)
#define V_PLANE_PADDED   48 /* taps in whole lanes */
#define V_PLANE_OFF_PX   3.0f
#define V_PLANE_NODE_MID ((V_PLANE_NODES - 1) / 2)

/* Numbers of one register, and four. */
#ifdef __AVX512F__
#define V_PLANE_WIDE 16
#elif defined __AVX2__
#define V_PLANE_WIDE 8
#else
#define V_PLANE_WIDE 4
#endif
typedef float v_plane_many __attribute__((vector_size(4 * V_PLANE_WIDE), may_alias));
typedef float v_plane_stored
    __attribute__((vector_size(4 * V_PLANE_WIDE), aligned(4), may_alias)); /* anywhere */
typedef float v_plane_four __attribute__((vector_size(16), may_alias));

/* fused.h, of a register's numbers. */
static inline v_plane_many v_plane_fused(v_plane_many a, v_plane_many b, v_plane_many c)
{
#if V_PLANE_WIDE == 16
    return (v_plane_many)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#elif V_PLANE_WIDE == 8
    return (v_plane_many)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
    return (v_plane_many)fused_4(a, b, c);
#endif
}

struct v_plane_taps {
    _Alignas(64) int32_t row[V_PLANE_PADDED];     /* from the pixel's */
    _Alignas(64) int32_t column[V_PLANE_PADDED];  /* from the pixel's */
    _Alignas(64) float number[6][V_PLANE_PADDED]; /* point, normal */
    _Alignas(64) float weight[V_PLANE_PADDED];    /* 0: refused */
    _Alignas(64) float shift[V_PLANE_PADDED];
    int32_t cell[V_PLANE_PADDED];
};

/* Rows to columns. */
static inline void v_plane_turn_fours(v_plane_four m[4])
{
    const v_plane_four a = m[0], b = m[1], c = m[2], d = m[3];
    const v_plane_four ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    const v_plane_four cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const v_plane_four ba = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const v_plane_four dc = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    m[0] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    m[1] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    m[2] = __builtin_shufflevector(ba, dc, 0, 1, 4, 5);
    m[3] = __builtin_shufflevector(ba, dc, 2, 3, 6, 7);
}

/* Where the taps lie and what they show. Returns their number, filled up to whole lanes. */
static inline uint32_t v_plane_place(const struct v_plane_walk *w, const struct v_plane_source *p,
                                     ptrdiff_t width, struct v_plane_taps *out)
{
    const int32_t count = 2 * w->reach + 1;
    const int32_t padded = (count + V_PLANE_LANES - 1) / V_PLANE_LANES * V_PLANE_LANES;
    for (int32_t i = 0; i < padded; i++) {
        const int32_t k = i < count ? i - w->reach : 0;
        const int32_t aside = (int32_t)floorf((float)k * w->slant + 0.5f);
        out->row[i] = w->along_x ? aside : k;
        out->column[i] = w->along_x ? k : aside;
    }
    for (int32_t i = 0; i < padded; i += 4) {
        v_plane_four point[4], normal[4];
        for (int32_t j = 0; j < 4; j++) {
            const struct v_plane_source *q = p + out->row[i + j] * width + out->column[i + j];
            memcpy(&point[j], q->point, sizeof point[j]); /* and what lies behind it */
            memcpy(&normal[j], q->normal, sizeof normal[j]);
        }
        v_plane_turn_fours(point);
        v_plane_turn_fours(normal);
        for (int c = 0; c < 3; c++) {
            memcpy(&out->number[c][i], &point[c], sizeof point[c]);
            memcpy(&out->number[3 + c][i], &normal[c], sizeof normal[c]);
        }
        memcpy(&out->cell[i], &normal[3], sizeof normal[3]);
    }
    for (int32_t i = 0; i < padded; i++) out->weight[i] = i < count ? 1.0f : 0.0f;
    return (uint32_t)padded;
}

/* Weights and shifts: exp(-d^2 / 2 sigma^2) and -eta d, d the way along the tangent. */
static inline void v_plane_weigh(const struct v_plane_walk *w, const struct v_plane_source *p,
                                 uint32_t count, struct v_plane_taps *taps)
{
    const float *x = p->point, *n = p->normal, *t = w->tangent;
    const float px = x[0], py = x[1], pz = x[2], nx = n[0], ny = n[1], nz = n[2];
    const float tx = t[0], ty = t[1], tz = t[2], eta = w->eta, falloff = w->falloff;
    const float least = V_PLANE_OFF_PX * p->pixel;
    float(*v)[V_PLANE_PADDED] = taps->number;
    for (uint32_t i = 0; i < count; i++) {
        const float dx = v[0][i] - px, dy = v[1][i] - py, dz = v[2][i] - pz;
        const float along = fused(dz, tz, fused(dy, ty, dx * tx));
        const float off = fabsf(fused(dz, nz, fused(dy, ny, dx * nx)));
        const float d2 = fused(dz, dz, fused(dy, dy, dx * dx));
        const float alike = fused(nz, v[5][i], fused(ny, v[4][i], nx * v[3][i]));
        const float shift = -eta * along;
        const float share = V_PLANE_OFF_SHARE * V_PLANE_OFF_SHARE;
        const int32_t flat = (off <= least) | (off * off <= share * d2);
        const int32_t kept =
            flat & (alike >= V_PLANE_COS_NORMALS) & (shift >= -1.0f) & (shift <= 1.0f);
        const float weight = taps->weight[i] * gaussian_exp_minus(along * along * falloff);
        taps->weight[i] = kept ? weight : 0.0f;
        taps->shift[i] = kept ? shift : 0.0f;
    }
}

/* The indices of the taps that count, those of each cell by themselves. */
struct v_plane_order {
    uint32_t count[V_PLANE_CELLS];
    uint8_t tap[V_PLANE_CELLS][V_PLANE_PADDED];
};

static inline void v_plane_sort(const struct v_plane_taps *taps, uint32_t count,
                                struct v_plane_order *out)
{
    memset(out->count, 0, sizeof out->count);
    for (uint32_t i = 0; i < count; i++) {
        const int32_t c = taps->cell[i];
        out->tap[c][out->count[c]] = (uint8_t)i;
        out->count[c] += taps->weight[i] > 0.0f;
    }
}

/* Sums of a register's strata over a cell's taps: r, g, b and weight; then each times the powers of
 * the cosine's square within the column. */
static inline void v_plane_gather(const struct v_plane_taps *taps, const float *const *records,
                                  const uint8_t *order, uint32_t count, size_t lanes, size_t at,
                                  v_plane_many sums[V_PLANE_POWERS * 4])
{
    for (uint32_t n = 0; n < V_PLANE_POWERS * 4; n++) sums[n] = (v_plane_many){0};
    for (uint32_t j = 0; j < count; j++) {
        const uint32_t i = order[j];
        const v_plane_many *record = (const v_plane_many *)(const void *)(records[i] + at);
        const size_t step = lanes / V_PLANE_WIDE;
        const v_plane_many shift = taps->shift[i] - (v_plane_many){0};
        /* at least 0.38 */
        const v_plane_many slope = v_plane_fused(-shift, record[step], record[0]);
        const v_plane_many ratio = v_plane_fused(-shift, slope, 1.0f - (v_plane_many){0});
        const v_plane_many inverse = 1.0f / ratio, cosine = record[2 * step] * inverse;
        v_plane_many w = taps->weight[i] * (inverse * inverse);
        for (uint32_t power = 0; power < V_PLANE_POWERS; power++, w *= cosine) {
            for (uint32_t c = 0; c < 3; c++)
                sums[4 * power + c] = v_plane_fused(w, record[(3 + c) * step], sums[4 * power + c]);
            sums[4 * power + 3] += w;
        }
    }
}

/* Sums of a cell over the rows of strata: r, g, b, weight and each times powers of cosine^2, of
 * four columns each. */
struct v_plane_columns {
    v_plane_four number[V_PLANE_STRATA_MAX / 4][V_PLANE_POWERS * 4];
};

/* Adds lanes from `first` on, four by four: in an order that does not hang on the register. */
static inline void v_plane_sum_rows(uint32_t l, const v_plane_many sums[V_PLANE_POWERS * 4],
                                    uint32_t first, struct v_plane_columns *out)
{
    enum { FOURS = V_PLANE_WIDE / 4 };
    const uint32_t blocks = v_plane_row_lanes(l) / 4, left = l * blocks - first / 4;
    v_plane_four number[V_PLANE_POWERS * 4][FOURS];
    memcpy(number, sums, sizeof number);
    for (uint32_t j = 0; j < FOURS && j < left; j++) {
        v_plane_four *to = out->number[(first / 4 + j) % blocks];
        for (uint32_t n = 0; n < V_PLANE_POWERS * 4; n++) to[n] += number[n][j];
    }
}

/* Of each column of strata: r, g, b and weight into cells[V_PLANE_POWERS (V_PLANE_CELLS i + c)],
 * the others behind. */
static inline void v_plane_store_cells(uint32_t l, struct v_plane_columns *columns, uint32_t c,
                                       v_plane_four *cells)
{
    for (uint32_t b = 0; 4 * b < l; b++) {
        v_plane_four *four = columns->number[b];
        for (uint32_t power = 0; power < V_PLANE_POWERS; power++)
            v_plane_turn_fours(four + 4 * power);
        for (uint32_t i = 0; i < 4 && 4 * b + i < l; i++) {
            v_plane_four *to = cells + V_PLANE_POWERS * (V_PLANE_CELLS * (4 * b + i) + c);
            for (uint32_t power = 0; power < V_PLANE_POWERS; power++)
                to[power] = four[4 * power + i];
        }
    }
}

#define V_PLANE_SUMS_MAX (V_PLANE_POWERS * V_PLANE_CELLS * V_PLANE_STRATA_MAX)
#define V_PLANE_TOGETHER                                                                           \
    4 /* pixels whose cells go to nodes at once: ratios are read that less often */
#define V_PLANE_AT_ONCE 2 /* registers of each pixel's nodes */

/* Cells of pixels beside each other in their row. */
struct v_plane_group {
    v_plane_four cells[V_PLANE_TOGETHER][V_PLANE_SUMS_MAX];
};

/* Which of `count` cells have any weight, of some pixel; they are all 0 in pixels where they have
 * none. Returns their number. */
LANES_INLINE uint32_t v_plane_keep(struct v_plane_group *group, uint32_t pixels, uint32_t count,
                                   uint32_t kept[V_PLANE_SUMS_MAX])
{
    uint32_t n = 0;
    for (uint32_t c = 0; c < count; c++) {
        bool any = false;
        for (uint32_t k = 0; k < pixels; k++) {
            v_plane_four *cell = &group->cells[k][c];
            const bool has = (*cell)[3] > 0.0f;
            if (!has) *cell = (v_plane_four){0};
            any |= has;
        }
        kept[n] = c;
        n += any;
    }
    return n;
}

/* A cell, again and again. */
static inline v_plane_many v_plane_repeat(const v_plane_four *cell)
{
#if V_PLANE_WIDE == 16
    return (v_plane_many)_mm512_broadcast_f32x4((__m128)*cell);
#elif V_PLANE_WIDE == 8
    return (v_plane_many)_mm256_broadcast_ps((const __m128 *)cell);
#else
    return *cell;
#endif
}

/* Pass 2a: from `count` cells of `pixels` to nodes, which lie V_PLANE_NODE_FLOATS apart. */
LANES_INLINE void v_plane_project(const float *ratios, struct v_plane_group *group, uint32_t pixels,
                                  uint32_t count, float *const out[V_PLANE_TOGETHER])
{
    enum { STEP = V_PLANE_AT_ONCE * V_PLANE_WIDE };
    uint32_t kept[V_PLANE_SUMS_MAX];
    const uint32_t n = v_plane_keep(group, pixels, count, kept);
    for (uint32_t first = 0; first < V_PLANE_NODE_FLOATS; first += STEP) {
        v_plane_many sums[V_PLANE_TOGETHER * V_PLANE_AT_ONCE];
        for (uint32_t i = 0; i < pixels * V_PLANE_AT_ONCE; i++) sums[i] = (v_plane_many){0};
        for (uint32_t c = 0; c < n; c++) {
            const float *at = ratios + (size_t)kept[c] * V_PLANE_NODE_FLOATS + first;
            const v_plane_many *ratio = (const v_plane_many *)(const void *)at;
            for (uint32_t k = 0; k < pixels; k++) {
                const v_plane_many cell = v_plane_repeat(&group->cells[k][kept[c]]);
                for (uint32_t i = 0; i < V_PLANE_AT_ONCE; i++)
                    sums[k * V_PLANE_AT_ONCE + i] =
                        v_plane_fused(ratio[i], cell, sums[k * V_PLANE_AT_ONCE + i]);
            }
        }
#pragma GCC unroll 8
        for (uint32_t i = 0; i < pixels * V_PLANE_AT_ONCE; i++)
            *(v_plane_stored *)(out[i / V_PLANE_AT_ONCE] + first +
                                i % V_PLANE_AT_ONCE * V_PLANE_WIDE) = sums[i];
    }
}

/* Passes 1a and 1b of one pixel, whose taps these are. */
static inline void v_plane_fill_cells(const struct v_plane_field *f,
                                      const struct v_plane_taps *taps, const float *const *records,
                                      const struct v_plane_order *order, v_plane_four *cells)
{
    const uint32_t l = f->strata, used = l * v_plane_row_lanes(l);
    for (uint32_t c = 0; c < V_PLANE_CELLS; c++) {
        struct v_plane_columns columns;
        memset(&columns, 0, (l + 3) / 4 * sizeof columns.number[0]);
        for (uint32_t at = 0; order->count[c] > 0 && at < used; at += V_PLANE_WIDE) {
            v_plane_many sums[V_PLANE_POWERS * 4];
            v_plane_gather(taps, records, order->tap[c], order->count[c], f->lanes, at, sums);
            v_plane_sum_rows(l, sums, at, &columns);
        }
        v_plane_store_cells(l, &columns, c, cells);
    }
}

/* Passes 1a and 1b of the pixel (x, y). */
static inline void v_plane_fill_pixel(const struct v_plane_field *f, int32_t x, int32_t y,
                                      const float *const *rows, v_plane_four *cells)
{
    const size_t size = v_plane_record_floats(f);
    const size_t p = (size_t)y * (size_t)f->width + (size_t)x;
    const struct v_plane_walk *w = &f->walks[1][p];
    const float *records[V_PLANE_PADDED];
    struct v_plane_taps taps;
    struct v_plane_order order;
    const uint32_t n = v_plane_place(w, &f->sources[p], f->width, &taps);
    v_plane_weigh(w, &f->sources[p], n, &taps);
    v_plane_sort(&taps, n, &order);
    for (uint32_t i = 0; i < n; i++)
        records[i] = rows[V_PLANE_REACH_PX + taps.row[i]] + (size_t)(x + taps.column[i]) * size;
    v_plane_fill_cells(f, &taps, records, &order, cells);
}

static void kernel_columns(const struct v_plane_field *f, int32_t y, const int32_t *x,
                           uint32_t count, const float *const *rows, float *out)
{
    const uint32_t sums = V_PLANE_POWERS * V_PLANE_CELLS * f->strata;
    struct v_plane_group group;
    for (uint32_t k = 0, n; k < count; k += n) {
        float *to[V_PLANE_TOGETHER];
        n = count - k < V_PLANE_TOGETHER ? 1 : V_PLANE_TOGETHER;
        for (uint32_t i = 0; i < n; i++) {
            to[i] = out + (size_t)x[k + i] * V_PLANE_NODE_FLOATS;
            v_plane_fill_pixel(f, x[k + i], y, rows, group.cells[i]);
        }
        if (n == V_PLANE_TOGETHER)
            v_plane_project(f->ratios, &group, V_PLANE_TOGETHER, sums, to);
        else
            v_plane_project(f->ratios, &group, 1, sums, to);
    }
}

/* Between which nodes taps are read, and how much of their weights is the lower and the upper
 * one's. */
struct v_plane_nodes {
    _Alignas(64) float below[V_PLANE_PADDED], above[V_PLANE_PADDED];
    _Alignas(64) int32_t at[V_PLANE_PADDED]; /* numbers from the pixel's own in the tap's row */
};

static inline void v_plane_find_nodes(const struct v_plane_taps *taps, uint32_t count,
                                      struct v_plane_nodes *out)
{
    for (uint32_t i = 0; i < count; i++) {
        const float node = fused(taps->shift[i], V_PLANE_NODE_MID, V_PLANE_NODE_MID);
        const float whole = floorf(node);
        const float weight = taps->weight[i], above = weight * (node - whole);
        out->above[i] = above;
        out->below[i] = weight - above;
        out->at[i] = taps->column[i] * V_PLANE_NODE_FLOATS + 4 * (int32_t)whole;
    }
}

static void kernel_rows(const struct v_plane_field *f, int32_t y, const int32_t *x, uint32_t count,
                        const float *const *rows, float *out)
{
    struct v_plane_taps taps;
    struct v_plane_nodes nodes;
    for (uint32_t k = 0; k < count; k++) {
        const size_t p = (size_t)y * (size_t)f->width + (size_t)x[k];
        const size_t own = (size_t)x[k] * V_PLANE_NODE_FLOATS;
        const struct v_plane_walk *w = &f->walks[0][p];
        const uint32_t n = v_plane_place(w, &f->sources[p], f->width, &taps);
        v_plane_four sum = {0};
        v_plane_weigh(w, &f->sources[p], n, &taps);
        v_plane_find_nodes(&taps, n, &nodes);
        for (uint32_t i = 0; i < n; i++) {
            if (!(taps.weight[i] > 0.0f)) continue;
            const float *row = rows[V_PLANE_REACH_PX + taps.row[i]] + own;
            const v_plane_four *at = (const v_plane_four *)(const void *)(row + nodes.at[i]);
            const v_plane_four below = nodes.below[i] - (v_plane_four){0};
            const v_plane_four above = nodes.above[i] - (v_plane_four){0};
            sum += fused_4(above, at[1], below * at[0]);
        }
        memcpy(out + 4 * (size_t)k, &sum, sizeof sum);
    }
}
