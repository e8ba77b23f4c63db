#pragma once
/* v_plane_kernels' walks. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/indirect/v_plane_kernels.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/gaussian.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

#define V_PLANE_TAPS     (2 * V_PLANE_REACH_PX + 1)
#define V_PLANE_PADDED   48 /* taps in whole lanes */
#define V_PLANE_OFF_PX   3.0f
#define V_PLANE_NODE_MID ((V_PLANE_NODES - 1) / 2)

typedef float v_plane_four __attribute__((vector_size(16), may_alias));

struct v_plane_taps {
    _Alignas(64) int32_t row[V_PLANE_PADDED];     /* from the pixel's */
    _Alignas(64) int32_t column[V_PLANE_PADDED];  /* from the pixel's */
    _Alignas(64) float number[6][V_PLANE_PADDED]; /* point, normal */
    _Alignas(64) float weight[V_PLANE_PADDED];    /* 0: refused */
    _Alignas(64) float shift[V_PLANE_PADDED];
    int32_t cell[V_PLANE_PADDED];
};

/* Turns rows into columns. */
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

/* Finds where the taps lie and what they show. Returns their number, filled up to whole lanes. */
static inline uint32_t v_plane_place_taps(const struct v_plane_walk *w,
                                          const struct v_plane_source *p, ptrdiff_t width,
                                          struct v_plane_taps *out)
{
    const int32_t count = 2 * w->reach + 1;
    const int32_t padded = (count + SIMD_LANES - 1) / SIMD_LANES * SIMD_LANES;
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

/* Computes weights and shifts: exp(-d^2 / 2 sigma^2) and -eta d, with d the way along the
 * tangent. */
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

/* The taps that count, cell by cell: a bit each, the first one's lowest. */
struct v_plane_order {
    uint64_t taps[V_PLANE_CELLS];
};
_Static_assert(V_PLANE_PADDED <= 64 && V_PLANE_PADDED % SIMD_PER_VECTOR == 0, "taps as bits");

static inline void v_plane_sort(const struct v_plane_taps *taps, uint32_t count,
                                struct v_plane_order *out)
{
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; i < count; i += SIMD_PER_VECTOR) {
        const simd_mask counts = simd_load_vector(taps->weight + i) > 0.0f;
        const simd_mask cells = simd_load_mask(taps->cell + i);
        for (int32_t c = 0; c < V_PLANE_CELLS; c++)
            out->taps[c] |= (uint64_t)simd_signs(counts & (cells == c)) << i;
    }
}

/* Sums a register's strata over a cell's taps: r, g, b and weight, then each times the powers of
 * the cosine's square within the column. */
static inline void v_plane_gather(const struct v_plane_taps *taps, const float *const *records,
                                  uint64_t own, size_t lanes, size_t at,
                                  simd_vector sums[V_PLANE_POWERS * 4])
{
    for (uint32_t n = 0; n < V_PLANE_POWERS * 4; n++) sums[n] = (simd_vector){0};
    for (uint64_t left = own; left != 0; left &= left - 1) {
        const int i = __builtin_ctzll(left);
        const simd_vector *record = (const simd_vector *)(const void *)(records[i] + at);
        const size_t step = lanes / SIMD_PER_VECTOR;
        const simd_vector shift = simd_same(taps->shift[i]);
        /* at least 0.38 */
        const simd_vector slope = simd_fused(-shift, record[step], record[0]);
        const simd_vector ratio = simd_fused(-shift, slope, simd_same(1.0f));
        const simd_vector inverse = 1.0f / ratio, cosine = record[2 * step] * inverse;
        simd_vector w = taps->weight[i] * (inverse * inverse);
        for (uint32_t power = 0; power < V_PLANE_POWERS; power++, w *= cosine) {
            for (uint32_t c = 0; c < 3; c++)
                sums[4 * power + c] = simd_fused(w, record[(3 + c) * step], sums[4 * power + c]);
            sums[4 * power + 3] += w;
        }
    }
}

/* Sums of a cell over the rows of strata: r, g, b, weight and each times powers of cosine^2, of
 * four columns each. */
struct v_plane_columns {
    v_plane_four number[V_PLANE_STRATA_MAX / 4][V_PLANE_POWERS * 4];
};

/* Adds lanes from `first` on, four by four, in an order that does not depend on the register. */
static inline void v_plane_sum_rows(uint32_t l, const simd_vector sums[V_PLANE_POWERS * 4],
                                    uint32_t first, struct v_plane_columns *out)
{
    enum { FOURS = SIMD_PER_VECTOR / 4 };
    const uint32_t blocks = v_plane_row_lanes(l) / 4, left = l * blocks - first / 4;
    v_plane_four number[V_PLANE_POWERS * 4][FOURS];
    memcpy(number, sums, sizeof number);
    for (uint32_t j = 0; j < FOURS && j < left; j++) {
        v_plane_four *to = out->number[(first / 4 + j) % blocks];
        for (uint32_t n = 0; n < V_PLANE_POWERS * 4; n++) to[n] += number[n][j];
    }
}

/* Stores the sums of each column of strata: r, g, b and weight in cells[V_PLANE_POWERS
 * (V_PLANE_CELLS i + c)], the others behind. */
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
/* Pixels whose cells go to nodes at once, and registers of each. The more there are, the less often
 * ratios are read. */
#define V_PLANE_TOGETHER 4
#define V_PLANE_AT_ONCE  2

/* Cells of pixels of the list. */
struct v_plane_group {
    v_plane_four cells[V_PLANE_TOGETHER][V_PLANE_SUMS_MAX];
    uint32_t directions; /* that any of them has taps of, a bit each; without, cells are 0 */
};

/* Lists the cells of those directions. Returns their number. */
static inline uint32_t v_plane_list(uint32_t strata, uint32_t directions,
                                    uint32_t out[V_PLANE_SUMS_MAX])
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < strata; i++)
        for (uint32_t left = directions; left != 0; left &= left - 1) {
            const uint32_t c = (uint32_t)__builtin_ctz(left);
            for (uint32_t power = 0; power < V_PLANE_POWERS; power++)
                out[n++] = V_PLANE_POWERS * (V_PLANE_CELLS * i + c) + power;
        }
    return n;
}

/* Returns a cell, repeated over the vector. */
static inline simd_vector v_plane_repeat(const v_plane_four *cell)
{
#if SIMD_PER_VECTOR == 16
    return (simd_vector)_mm512_broadcast_f32x4((__m128)*cell);
#elif SIMD_PER_VECTOR == 8
    return (simd_vector)_mm256_broadcast_ps((const __m128 *)cell);
#else
    return *cell;
#endif
}

/* Runs pass 2a, from the cells of `pixels` to nodes, V_PLANE_NODE_FLOATS of each. */
SIMD_INLINE void v_plane_project(const struct v_plane_field *f, const struct v_plane_group *group,
                                 uint32_t pixels, float *const out[V_PLANE_TOGETHER])
{
    enum { STEP = V_PLANE_AT_ONCE * SIMD_PER_VECTOR };
    uint32_t cells[V_PLANE_SUMS_MAX];
    const uint32_t n = v_plane_list(f->strata, group->directions, cells);
    for (uint32_t first = 0; first < V_PLANE_NODE_FLOATS; first += STEP) {
        simd_vector sums[V_PLANE_TOGETHER * V_PLANE_AT_ONCE];
        for (uint32_t i = 0; i < pixels * V_PLANE_AT_ONCE; i++) sums[i] = (simd_vector){0};
        for (uint32_t c = 0; c < n; c++) {
            const float *at = f->ratios + (size_t)cells[c] * V_PLANE_NODE_FLOATS + first;
            const simd_vector *ratio = (const simd_vector *)(const void *)at;
            for (uint32_t k = 0; k < pixels; k++) {
                const simd_vector cell = v_plane_repeat(&group->cells[k][cells[c]]);
                for (uint32_t i = 0; i < V_PLANE_AT_ONCE; i++)
                    sums[k * V_PLANE_AT_ONCE + i] =
                        simd_fused(ratio[i], cell, sums[k * V_PLANE_AT_ONCE + i]);
            }
        }
#pragma GCC unroll 8
        for (uint32_t i = 0; i < pixels * V_PLANE_AT_ONCE; i++)
            *(simd_stored *)(out[i / V_PLANE_AT_ONCE] + first +
                             i % V_PLANE_AT_ONCE * SIMD_PER_VECTOR) = sums[i];
    }
}

/* Runs passes 1a and 1b for the pixel with these taps. */
static inline void v_plane_fill_cells(const struct v_plane_field *f,
                                      const struct v_plane_taps *taps, const float *const *records,
                                      const struct v_plane_order *order, v_plane_four *cells)
{
    const uint32_t l = f->strata, used = l * v_plane_row_lanes(l);
    for (uint32_t c = 0; c < V_PLANE_CELLS; c++) {
        struct v_plane_columns columns;
        memset(&columns, 0, (l + 3) / 4 * sizeof columns.number[0]);
        for (uint32_t at = 0; order->taps[c] != 0 && at < used; at += SIMD_PER_VECTOR) {
            simd_vector sums[V_PLANE_POWERS * 4];
            v_plane_gather(taps, records, order->taps[c], f->lanes, at, sums);
            v_plane_sum_rows(l, sums, at, &columns);
        }
        v_plane_store_cells(l, &columns, c, cells);
    }
}

/* Runs passes 1a and 1b for the pixel (x, y). Returns the directions that it has taps of, a bit
 * each. */
static inline uint32_t v_plane_fill_pixel(const struct v_plane_field *f, int32_t x, int32_t y,
                                          const float *const *rows, v_plane_four *cells)
{
    const size_t size = v_plane_record_floats(f);
    const size_t p = (size_t)y * (size_t)f->width + (size_t)x;
    const struct v_plane_walk *w = &f->walks[1][p];
    const float *records[V_PLANE_PADDED];
    struct v_plane_taps taps;
    struct v_plane_order order;
    const uint32_t n = v_plane_place_taps(w, &f->sources[p], f->width, &taps);
    v_plane_weigh(w, &f->sources[p], n, &taps);
    v_plane_sort(&taps, n, &order);
    for (uint32_t i = 0; i < n; i++)
        records[i] = rows[V_PLANE_REACH_PX + taps.row[i]] + (size_t)(x + taps.column[i]) * size;
    v_plane_fill_cells(f, &taps, records, &order, cells);
    uint32_t directions = 0;
    for (uint32_t c = 0; c < V_PLANE_CELLS; c++) directions |= (uint32_t)(order.taps[c] != 0) << c;
    return directions;
}

static void kernel_columns(const struct v_plane_field *f, int32_t y, const int32_t *x,
                           uint32_t count, const float *const *rows, float *out)
{
    struct v_plane_group group;
    for (uint32_t k = 0, n; k < count; k += n) {
        float *to[V_PLANE_TOGETHER];
        n = count - k < V_PLANE_TOGETHER ? 1 : V_PLANE_TOGETHER;
        group.directions = 0;
        for (uint32_t i = 0; i < n; i++) {
            to[i] = out + (size_t)x[k + i] * V_PLANE_NODE_FLOATS;
            group.directions |= v_plane_fill_pixel(f, x[k + i], y, rows, group.cells[i]);
        }
        if (n == V_PLANE_TOGETHER)
            v_plane_project(f, &group, V_PLANE_TOGETHER, to);
        else
            v_plane_project(f, &group, 1, to);
    }
}

/* The nodes between which taps are read, and the parts of their weights that the lower and the
 * upper one get. */
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
        const uint32_t n = v_plane_place_taps(w, &f->sources[p], f->width, &taps);
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
