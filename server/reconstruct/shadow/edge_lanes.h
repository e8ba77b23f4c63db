#pragma once
/* The filter_edges of shadow_kernels. */
#include <math.h>

#include "proto/pattern.h"
#include "server/reconstruct/shadow/edge_window_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/gaussian_lanes.h"
#include "server/reconstruct/simd/inline.h"

#define EDGE_TOGETHER     4    /* pixels whose neighbours are loaded before any are summed */
#define EDGE_PARTS        2    /* parts of a sum, to which neighbours are added in turn */
#define EDGE_EXPONENT_MAX 3.0f /* 2.4 sigma */

/* I / cov along an axis of the light: at all nodes but the last, and the rise to the next node. */
struct edge_weights {
    _Alignas(32) float even[EDGE_NODES], rise[EDGE_NODES];
};

/* The neighbours in the window, packed, and padded to whole lanes with weightless ones. */
struct edge_neighbours {
    _Alignas(64) float exponents[EDGE_AROUND]; /* of all pixels around */
    int32_t near[EDGE_AROUND]; /* indices of those in the window; the arrays below are theirs */
    int32_t at[EDGE_AROUND];
    int32_t bits[EDGE_AROUND]; /* of the first 32 strata */
    float exponent[EDGE_AROUND], u[2][EDGE_AROUND], jitter[2][EDGE_AROUND];
    size_t count;
};
_Static_assert(SIMD_LANES + EDGE_SIDE * EDGE_SIDE <= EDGE_AROUND, "room for all and the lanes");

/* Computes I / cov of docs/reconstruction.md, Sample weights, at both axes' nodes but the last. */
static inline void edge_weigh_nodes(const struct edge_fixed *fixed, const struct edge_windows *w,
                                    uint32_t lane, struct edge_weights out[2])
{
    typedef float eight __attribute__((vector_size(32), aligned(4), may_alias));
    const float reach[] = {w->reach[0][lane], w->reach[1][lane]};
    const float inverse[] = {w->inverse[0][lane], w->inverse[1][lane]};
    const float all[] = {w->all[0][lane], w->all[1][lane]};
    const float rest[] = {w->rest[0][lane], w->rest[1][lane]};
    _Alignas(64) float at[SIMD_LANES];
    for (int i = 0; i < SIMD_LANES; i++) {
        const int second = i >= EDGE_NODES, node = i % EDGE_NODES;
        const struct coverage_shear s = {second ? reach[1] : reach[0],
                                         second ? inverse[1] : inverse[0], second ? all[1] : all[0],
                                         second ? rest[1] : rest[0]};
        at[i] = fixed->profile[i] / coverage_at(&s, (float)node / EDGE_NODES);
    }
    for (int k = 0; k < 2; k++) {
        const eight even = *(const eight *)(at + (ptrdiff_t)EDGE_NODES * k);
        const eight last = w->last[k][lane] - (eight){0};
        *(eight *)out[k].even = even;
        *(eight *)out[k].rise = __builtin_shufflevector(even, last, 1, 2, 3, 4, 5, 6, 7, 8) - even;
    }
}

/* Lists the neighbours in the window, in order, and the exponents of all. They are accepted in
 * pairs opposite each other, so that linear changes cancel. */
static inline void edge_choose(const struct edge_fixed *fixed, const struct edge_view *v,
                               const struct edge_windows *w, uint32_t lane,
                               struct edge_neighbours *out)
{
    const int32_t told = w->told[lane];
    const float ax = w->across[0][lane], ay = w->across[1][lane];
    const float across_falloff = w->falloff[0][lane], along_falloff = w->falloff[1][lane];
    for (int row = 0; row < EDGE_AROUND; row += SIMD_LANES) {
        const int32_t *same = edge_same(v) + row;
        const int32_t *opposite = edge_same(v) + (EDGE_SIDE - 1) * (SIMD_LANES + 1) - row;
        for (int i = 0; i < SIMD_LANES; i++) {
            const float x = fixed->x[row + i], y = fixed->y[row + i];
            const float across = fused(y, ay, x * ax), along = fused(y, ax, -x * ay);
            const float exponent =
                fused(across * across, across_falloff, along * along * along_falloff);
            out->exponents[row + i] = exponent;
            out->near[row + i] = told & same[i] & opposite[-i] & (exponent <= EDGE_EXPONENT_MAX);
        }
    }
}

/* edge_load loads the neighbours of the window. Lanes past the end repeat the pixel itself with a
 * weight of 0. */

#ifdef __AVX512F__

/* Packs the lanes of `kept` of 16 numbers. */
SIMD_INLINE void edge_keep(__mmask16 kept, const void *numbers, void *out)
{
    _mm512_storeu_si512(out,
                        _mm512_maskz_compress_epi32(kept, _mm512_maskz_loadu_epi32(kept, numbers)));
}

/* Loads the 16 neighbours from q on. */
static inline void edge_load_row(const struct edge_field *f, size_t q, const float *exponents,
                                 __mmask16 kept, struct edge_neighbours *n)
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i at = _mm512_add_epi32(_mm512_set1_epi32((int32_t)q), lane);
    const size_t to = n->count;
    _mm512_storeu_si512(n->at + to, _mm512_maskz_compress_epi32(kept, at));
    edge_keep(kept, exponents, n->exponent + to);
    edge_keep(kept, f->bits + q, n->bits + to);
    for (int k = 0; k < 2; k++) {
        edge_keep(kept, f->pixels->u[k] + q, n->u[k] + to);
        edge_keep(kept, f->jitter[k] + q, n->jitter[k] + to);
    }
    n->count += (size_t)__builtin_popcount(kept);
}

static inline void edge_load(const struct edge_field *f, const struct edge_fixed *fixed,
                             size_t pixel, struct edge_neighbours *n)
{
    n->count = 0;
    for (int row = 0; row < EDGE_AROUND; row += SIMD_LANES) {
        const __m512i near = _mm512_load_si512(n->near + row);
        const __mmask16 kept = _mm512_test_epi32_mask(near, near);
        const size_t q = (size_t)((ptrdiff_t)pixel + fixed->to[row]);
        if (kept != 0) edge_load_row(f, q, n->exponents + row, kept, n);
    }
    const size_t end = n->count;
    _mm512_storeu_si512(n->at + end, _mm512_set1_epi32((int32_t)pixel));
    _mm512_storeu_si512(n->bits + end, _mm512_set1_epi32((int32_t)f->bits[pixel]));
    _mm512_storeu_ps(n->exponent + end, _mm512_set1_ps(INFINITY));
    for (int k = 0; k < 2; k++) {
        _mm512_storeu_ps(n->u[k] + end, _mm512_set1_ps(f->pixels->u[k][pixel]));
        _mm512_storeu_ps(n->jitter[k] + end, _mm512_set1_ps(f->jitter[k][pixel]));
    }
}

#else

static inline void edge_load(const struct edge_field *f, const struct edge_fixed *fixed,
                             size_t pixel, struct edge_neighbours *n)
{
    int32_t kept[EDGE_AROUND];
    n->count = simd_kept(n->near, EDGE_AROUND, kept);
    for (size_t i = 0; i < n->count || i % SIMD_LANES != 0; i++) {
        const bool has = i < n->count;
        const size_t q = (size_t)((ptrdiff_t)pixel + (has ? fixed->to[kept[i]] : 0));
        n->at[i] = (int32_t)q;
        n->exponent[i] = has ? n->exponents[kept[i]] : INFINITY;
        n->bits[i] = (int32_t)f->bits[q];
        for (int k = 0; k < 2; k++) {
            n->u[k][i] = f->pixels->u[k][q];
            n->jitter[k][i] = f->jitter[k][q];
        }
    }
}

#endif

/* Returns entries 0 .. 7 of a table by index. */
static inline simd_vector edge_look_up(const float table[EDGE_NODES], simd_mask numbers)
{
#ifdef __AVX512F__
    const __m512 all = _mm512_castps256_ps512(_mm256_load_ps(table));
    return (simd_vector)_mm512_permutexvar_ps((__m512i)numbers, all);
#elif defined __AVX2__
    return (simd_vector)_mm256_permutevar8x32_ps(_mm256_load_ps(table), (__m256i)numbers);
#else
    simd_vector out = {0};
    for (int i = 0; i < SIMD_PER_VECTOR; i++) out[i] = table[numbers[i]];
    return out;
#endif
}

/* Loads jitters, limited as pattern_axis does. */
static inline struct simd edge_jitter(const float *from)
{
    struct simd jitter = simd_load(from);
    const struct simd most = simd_all(PATTERN_JITTER_MAX);
    for (int v = 0; v < SIMD_VECTORS; v++) jitter.v[v] = simd_min(jitter.v[v], most.v[v]);
    return jitter;
}

/* Returns w_i of docs/reconstruction.md, Sample weights, at the k-th of l strata as pattern_axis
 * places it; 0 off the light. */
static inline simd_vector edge_weigh(const struct edge_weights *w, float gamma, uint32_t l,
                                     uint32_t k, simd_vector jitter, simd_vector shift)
{
    const simd_vector y = 2.0f * (((float)k + jitter) / (float)l) - 1.0f + shift;
    const simd_vector at = simd_positive(y) * (float)EDGE_NODES;
    const simd_mask inside = at <= (float)EDGE_NODES;
    const simd_mask below = __builtin_convertvector(simd_where(inside, at), simd_mask);
    const simd_mask node = below + (below == EDGE_NODES); /* the last node has no next one */
    const simd_vector rest = at - __builtin_convertvector(node, simd_vector);
    const simd_vector weight =
        simd_fused(edge_look_up(w->rise, node), rest, edge_look_up(w->even, node));
    return simd_where(inside, weight * simd_fused(y, simd_same(gamma), simd_same(1.0f)));
}

/* Numbers of the centre pixel that all its neighbours share. */
struct edge_centre {
    const struct edge_weights *weights; /* of both axes */
    float u[2], normal[2], move[2], gamma[2], distance;
    uint32_t strata;
};

static inline struct edge_centre edge_centre_of(const struct edge_field *f, size_t pixel,
                                                const struct edge_windows *w, uint32_t lane,
                                                const struct edge_weights weights[2])
{
    const struct shadow_pixels *p = f->pixels;
    struct edge_centre c = {
        .weights = weights, .distance = p->distance[pixel], .strata = f->light->strata};
    for (int k = 0; k < 2; k++) {
        c.u[k] = p->u[k][pixel];
        c.normal[k] = w->normal[k][lane];
        c.move[k] = p->eta[pixel] * c.normal[k] / f->light->rectangle.half[k];
        c.gamma[k] = p->gamma[k][pixel];
    }
    return c;
}

/* Returns the words with stratum k of the neighbours. */
static inline struct simd_whole edge_bits(const struct edge_field *f, uint32_t k, const int32_t *at)
{
    const uint32_t *word = f->bits + k / 32 * f->stride;
    _Alignas(64) int32_t bits[SIMD_LANES];
    for (size_t i = 0; i < SIMD_LANES; i++) bits[i] = (int32_t)word[at[i]];
    return simd_load_whole(bits);
}

/* Sums by lane. */
struct edge_sums {
    struct simd seen, all;
};

/* Adds stratum `bit` of the words. */
static inline void edge_count(const struct simd *column, const struct simd *row,
                              const struct simd_whole *bits, uint32_t bit, struct edge_sums *sums)
{
    const int32_t own = (int32_t)(1u << bit);
    for (int v = 0; v < SIMD_VECTORS; v++) {
        const simd_vector whole = column->v[v] * row->v[v];
        sums->seen.v[v] += simd_where((bits->v[v] & own) != 0, whole);
        sums->all.v[v] += whole;
    }
}

/* Adds the strata of neighbours from index `first` on, moved to the pixel's position: the seen
 * ones, and all. */
static inline void edge_add(const struct edge_field *f, const struct edge_centre *c,
                            const struct edge_neighbours *n, size_t first, struct edge_sums *sums)
{
    const uint32_t l = c->strata;
    const float *u = n->u[0] + first, *v = n->u[1] + first;
    struct simd column[SHADOW_STRATA_MAX], shift[2], weight;
    struct simd_whole bits = simd_load_whole(n->bits + first);
    weight = simd_load(n->exponent + first);
    for (int i = 0; i < SIMD_VECTORS; i++) weight.v[i] = gaussian_exp_minus_lanes(weight.v[i]);
    for (int i = 0; i < SIMD_VECTORS; i++) {
        const simd_vector du = simd_load_vector(u + i * SIMD_PER_VECTOR) - c->u[0];
        const simd_vector dv = simd_load_vector(v + i * SIMD_PER_VECTOR) - c->u[1];
        const simd_vector apart =
            c->distance * simd_fused(dv, simd_same(c->normal[1]), du * c->normal[0]);
        for (int k = 0; k < 2; k++) shift[k].v[i] = c->move[k] * apart;
    }
    struct simd jitter = edge_jitter(n->jitter[0] + first);
    for (uint32_t a = 0; a < l; a++)
        for (int i = 0; i < SIMD_VECTORS; i++)
            column[a].v[i] = weight.v[i] * edge_weigh(&c->weights[0], c->gamma[0], l, a,
                                                      jitter.v[i], shift[0].v[i]);
    jitter = edge_jitter(n->jitter[1] + first);
    for (uint32_t k = 0, b = 0; b < l; b++) {
        struct simd row;
        for (int i = 0; i < SIMD_VECTORS; i++)
            row.v[i] = edge_weigh(&c->weights[1], c->gamma[1], l, b, jitter.v[i], shift[1].v[i]);
        for (uint32_t a = 0; a < l; a++, k++) {
            if (k > 0 && k % 32 == 0) bits = edge_bits(f, k, n->at + first);
            edge_count(&column[a], &row, &bits, k % 32, sums);
        }
    }
}

static inline float edge_total(const struct simd *a, const struct simd *b)
{
    struct simd both;
    _Alignas(64) float all[SIMD_LANES];
    for (int v = 0; v < SIMD_VECTORS; v++) both.v[v] = a->v[v] + b->v[v];
    simd_store(&both, all);
    return simd_sum(all);
}

static inline float edge_sum(const struct edge_field *f, const struct edge_centre *centre,
                             const struct edge_neighbours *near)
{
    struct edge_sums sums[EDGE_PARTS] = {{{{{0}}}, {{{0}}}}};
    for (size_t first = 0; first < near->count; first += SIMD_LANES)
        edge_add(f, centre, near, first, &sums[first / SIMD_LANES % EDGE_PARTS]);
    const float whole = edge_total(&sums[0].all, &sums[1].all);
    const float share = edge_total(&sums[0].seen, &sums[1].seen);
    return whole > 0.0f ? share / whole : -1.0f;
}

/* Filters EDGE_TOGETHER pixels from index `first` of the windows on. Numbers are stored one by one
 * long before they are read as vectors. */
static inline void edge_filter_some(const struct edge_field *f, const struct edge_fixed *fixed,
                                    const uint32_t *pixels, uint32_t first, uint32_t end,
                                    const struct edge_view *views, const struct edge_windows *w,
                                    float *out)
{
    struct edge_neighbours near[EDGE_TOGETHER];
    struct edge_weights weights[EDGE_TOGETHER][2];
    for (uint32_t i = first; i < end; i++) {
        struct edge_neighbours *own = &near[i - first];
        edge_weigh_nodes(fixed, w, i, weights[i - first]);
        edge_choose(fixed, &views[i], w, i, own);
        edge_load(f, fixed, pixels[i], own);
    }
    for (uint32_t i = first; i < end; i++) {
        const struct edge_centre centre = edge_centre_of(f, pixels[i], w, i, weights[i - first]);
        out[i] = edge_sum(f, &centre, &near[i - first]);
    }
}

/* Makes windows for adjacent pixels together. All views are filled before any is evaluated:
 * unaligned reads cross several stores, which have to be in the cache by then. */
static void kernel_filter_edges(const struct edge_field *f, const uint32_t *pixels,
                                const float *sigma_px, uint32_t count, float *out)
{
    struct edge_fixed fixed;
    struct edge_view views[SIMD_LANES] = {0};
    struct edge_windows windows = {0};
    edge_fix(f, &fixed);
    for (uint32_t first = 0; first < count; first += SIMD_LANES) {
        const uint32_t left = count - first, n = left < SIMD_LANES ? left : SIMD_LANES;
        for (uint32_t i = 0; i < n; i++) edge_look(f, &fixed, pixels[first + i], &views[i]);
        for (uint32_t i = 0; i < n; i++)
            edge_ask(f, &fixed, pixels[first + i], sigma_px[first + i], i, &views[i], &windows);
        edge_make_windows(f, &fixed, &windows);
        for (uint32_t i = 0; i < n; i += EDGE_TOGETHER)
            edge_filter_some(f, &fixed, pixels + first, i,
                             n - i < EDGE_TOGETHER ? n : i + EDGE_TOGETHER, views, &windows,
                             out + first);
    }
}
