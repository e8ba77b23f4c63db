#pragma once
/* v_plane_kernels' walks. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/v_plane_kernels.h"

#define V_PLANE_TAPS     (2 * V_PLANE_REACH_PX + 1)
#define V_PLANE_PADDED   48 /* taps in whole lanes */
#define V_PLANE_OFF_PX   3.0f
#define V_PLANE_NODE_MID ((V_PLANE_NODES - 1) / 2)

/* Sixteen numbers side by side, in as many registers as that takes; and four. */
typedef float v_plane_many __attribute__((vector_size(64), may_alias));
typedef float v_plane_four __attribute__((vector_size(16), may_alias));

struct v_plane_taps {
    _Alignas(64) int32_t row[V_PLANE_PADDED];     /* from the pixel's */
    _Alignas(64) int32_t column[V_PLANE_PADDED];  /* from the pixel's */
    _Alignas(64) float number[6][V_PLANE_PADDED]; /* point, normal */
    _Alignas(64) float weight[V_PLANE_PADDED];    /* 0: refused */
    _Alignas(64) float shift[V_PLANE_PADDED];
    int32_t cell[V_PLANE_PADDED];
};

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
    for (int32_t i = 0; i < padded; i++) {
        const struct v_plane_source *q = p + out->row[i] * width + out->column[i];
        for (int c = 0; c < 3; c++) {
            out->number[c][i] = q->point[c];
            out->number[3 + c][i] = q->normal[c];
        }
        out->cell[i] = q->cell;
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
        const float along = dx * tx + dy * ty + dz * tz;
        const float off = fabsf(dx * nx + dy * ny + dz * nz), d2 = dx * dx + dy * dy + dz * dz;
        const float alike = nx * v[3][i] + ny * v[4][i] + nz * v[5][i];
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

/* The indices of taps that count, those of one cell after those of the last: cell c's are
 * order[first[c]] .. order[first[c + 1] - 1]. */
static inline void v_plane_sort(const struct v_plane_taps *taps, uint32_t count,
                                uint32_t first[V_PLANE_CELLS + 1],
                                uint8_t order[V_PLANE_CELLS * V_PLANE_PADDED])
{
    uint32_t kept = 0;
    for (int32_t c = 0; c < V_PLANE_CELLS; c++) {
        first[c] = kept;
        for (uint32_t i = 0; i < count; i++) {
            order[kept] = (uint8_t)i;
            kept += (taps->weight[i] > 0.0f) & (taps->cell[i] == c);
        }
    }
    first[V_PLANE_CELLS] = kept;
}

/* Sums of sixteen strata over a cell's taps: r, g, b and weight. */
static inline void v_plane_gather(const struct v_plane_taps *taps, const float *const *records,
                                  const uint8_t *order, uint32_t count, size_t lanes, size_t at,
                                  v_plane_many sums[4])
{
    v_plane_many r = {0}, g = {0}, b = {0}, all = {0};
    for (uint32_t j = 0; j < count; j++) {
        const uint32_t i = order[j];
        const v_plane_many *record = (const v_plane_many *)(const void *)(records[i] + at);
        const size_t step = lanes / V_PLANE_LANES;
        const float shift = taps->shift[i];
        const v_plane_many ratio = 1.0f - shift * (record[0] - shift * record[step]);
        const v_plane_many w = taps->weight[i] / (ratio * ratio); /* ratio is at least 0.38 */
        r += w * record[2 * step];
        g += w * record[3 * step];
        b += w * record[4 * step];
        all += w;
    }
    sums[0] = r;
    sums[1] = g;
    sums[2] = b;
    sums[3] = all;
}

/* Adds up what the strata of one column gave: cells[V_PLANE_CELLS i + c] of column i. */
static inline void v_plane_sum_rows(uint32_t l, const v_plane_many sums[4], uint32_t first,
                                    uint32_t c, v_plane_four *cells)
{
    const float *r = (const float *)&sums[0], *g = (const float *)&sums[1];
    const float *b = (const float *)&sums[2], *w = (const float *)&sums[3];
    for (uint32_t j = 0; j < V_PLANE_LANES && first + j < l * l; j++) {
        const v_plane_four sample = {r[j], g[j], b[j], w[j]};
        cells[V_PLANE_CELLS * ((first + j) % l) + c] += sample;
    }
}

/* Pass 2a: from cells to nodes. */
static inline void v_plane_project(const float *ratios, uint32_t cells, const v_plane_four *cell,
                                   float *out)
{
    for (uint32_t at = 0; at < V_PLANE_NODE_FLOATS; at += 4 * V_PLANE_LANES) {
        v_plane_many sums[4] = {{0}, {0}, {0}, {0}};
        for (uint32_t c = 0; c < cells; c++) {
            if (!(cell[c][3] > 0.0f)) continue;
            const v_plane_many *ratio =
                (const v_plane_many *)(const void *)(ratios + (size_t)c * V_PLANE_NODE_FLOATS + at);
            v_plane_many four;
            for (uint32_t i = 0; i < 4; i++)
                memcpy((float *)&four + 4 * i, &cell[c], sizeof cell[c]);
            for (uint32_t i = 0; i < 4; i++) sums[i] += ratio[i] * four;
        }
        memcpy(out + at, sums, sizeof sums);
    }
}

static void kernel_columns(const struct v_plane_field *f, int32_t y, const int32_t *x,
                           uint32_t count, const float *const *rows, float *out)
{
    const uint32_t l = f->strata;
    const size_t size = v_plane_record_floats(f);
    struct v_plane_taps taps;
    const float *records[V_PLANE_PADDED];
    uint8_t order[V_PLANE_CELLS * V_PLANE_PADDED];
    uint32_t first[V_PLANE_CELLS + 1];
    for (uint32_t k = 0; k < count; k++) {
        const size_t p = (size_t)y * (size_t)f->width + (size_t)x[k];
        const struct v_plane_walk *w = &f->walks[1][p];
        v_plane_four cells[V_PLANE_CELLS * V_PLANE_STRATA_MAX] = {{0}};
        const uint32_t n = v_plane_place(w, &f->sources[p], f->width, &taps);
        v_plane_weigh(w, &f->sources[p], n, &taps);
        v_plane_sort(&taps, n, first, order);
        for (uint32_t i = 0; i < n; i++)
            records[i] =
                rows[V_PLANE_REACH_PX + taps.row[i]] + (size_t)(x[k] + taps.column[i]) * size;
        for (uint32_t at = 0; at < f->lanes; at += V_PLANE_LANES) {
            for (uint32_t c = 0; c < V_PLANE_CELLS; c++) {
                v_plane_many sums[4];
                if (first[c] == first[c + 1]) continue;
                v_plane_gather(&taps, records, order + first[c], first[c + 1] - first[c], f->lanes,
                               at, sums);
                v_plane_sum_rows(l, sums, at, c, cells);
            }
        }
        v_plane_project(f->ratios, V_PLANE_CELLS * l, cells,
                        out + (size_t)x[k] * V_PLANE_NODE_FLOATS);
    }
}

static void kernel_rows(const struct v_plane_field *f, int32_t y, const int32_t *x, uint32_t count,
                        const float *const *rows, float *out)
{
    struct v_plane_taps taps;
    for (uint32_t k = 0; k < count; k++) {
        const size_t p = (size_t)y * (size_t)f->width + (size_t)x[k];
        const struct v_plane_walk *w = &f->walks[0][p];
        const uint32_t n = v_plane_place(w, &f->sources[p], f->width, &taps);
        v_plane_four sum = {0};
        v_plane_weigh(w, &f->sources[p], n, &taps);
        for (uint32_t i = 0; i < n; i++) {
            if (!(taps.weight[i] > 0.0f)) continue;
            const float node = (taps.shift[i] + 1.0f) * V_PLANE_NODE_MID, whole = floorf(node);
            const float above = taps.weight[i] * (node - whole), below = taps.weight[i] - above;
            const v_plane_four *at =
                (const v_plane_four *)(const void *)(rows[V_PLANE_REACH_PX + taps.row[i]] +
                                                     (size_t)(x[k] + taps.column[i]) *
                                                         V_PLANE_NODE_FLOATS) +
                (size_t)whole;
            sum += below * at[0] + above * at[1];
        }
        memcpy(out + 4 * (size_t)k, &sum, sizeof sum);
    }
}
