#pragma once
/* Pass 1a of shadow_kernels, the projection along columns, and what both projections read of a
 * pixel. */
#include <math.h>
#include <string.h>

#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/lanes.h"

#define PROJECT_GROUP 8 /* pixels whose weights are all written before any is read */

/* Where the strata of adjacent pixels begin: the first node, its distance from the stratum's
 * sample, the rows of weights of the phases below and above, and the distance from the phase
 * below. */
struct project_start {
    _Alignas(64) int32_t node[SIMD_LANES], below[SIMD_LANES], above[SIMD_LANES];
    float g[SIMD_LANES], rest[SIMD_LANES];
};

static inline void project_begin(const struct shadow_field *f, uint32_t stratum,
                                 const float jitter[SIMD_LANES], struct project_start *out)
{
    const float strata_nodes = (float)f->scale / (float)f->strata, a = (float)stratum;
    const int32_t window = (int32_t)f->window;
    for (int i = 0; i < SIMD_LANES; i++) {
        const float at = (a + jitter[i]) * strata_nodes, first = ceilf(at), g = first - at;
        const float phase = g * SHADOW_PHASES, whole = floorf(phase);
        const int32_t below = (int32_t)whole;
        out->node[i] = (int32_t)first;
        out->g[i] = g;
        out->below[i] = below * window;
        out->above[i] = (below < SHADOW_PHASES ? below + 1 : below) * window;
        out->rest[i] = phase - whole;
    }
}

/* Finds these for all strata of up to SIMD_LANES of the `left` pixels. */
SIMD_INLINE void project_begin_all(const struct shadow_field *f, uint32_t strata,
                                   const float *jitter, uint32_t left, struct project_start *out)
{
    _Alignas(64) float own[SIMD_LANES] = {0};
    if (left >= SIMD_LANES) /* copied in one piece, as it is read */
        memcpy(own, jitter, sizeof own);
    else
        memcpy(own, jitter, left * sizeof *own);
    for (uint32_t a = 0; a < strata; a++) project_begin(f, a, own, &out[a]);
}

/* A pixel's row of weights. 1 + gamma y at g nodes from the sample is base + slope g. */
struct project_row {
    const float *weights;
    float base, slope;
};

static inline struct project_row project_row_of(const struct shadow_field *f, uint32_t axis,
                                                uint32_t pixel)
{
    const size_t row = (size_t)f->pixels->weights[axis][pixel] * (SHADOW_PHASES + 1);
    const float gamma = f->pixels->gamma[axis][pixel]; /* y = 1 - 2 g / scale */
    return (struct project_row){f->weights + row * f->window, 1.0f + gamma,
                                -gamma * (2.0f / (float)f->scale)};
}

/* Computes weight(g + j) (1 + gamma y_j) of the nodes j < r, linearly between two phases; 0 from r
 * on. */
SIMD_INLINE void project_weigh(const struct project_row *row, uint32_t window, int32_t below,
                               int32_t above, float g, float rest, float *out)
{
    const fused_eight none = {0}, rests = rest - none, slope = row->slope - none;
    const fused_eight own = fused(row->slope, g, row->base) - none;
    const float *from = row->weights;
    fused_eight nodes = {0, 1, 2, 3, 4, 5, 6, 7};
    for (uint32_t j = 0; j < window; j += 8, nodes += 8.0f) {
        const fused_eight low = *(const fused_eight *)(from + below + j);
        const fused_eight high = *(const fused_eight *)(from + above + j);
        const fused_eight rise = high - low;
        fused_eight cover = low, bend = own;
        fused_add_8(&rise, &rests, &cover);
        fused_add_8(&slope, &nodes, &bend);
        *(fused_eight *)(out + j) = cover * bend;
    }
}

/* The strata of a pixel. */
struct project_strata {
    _Alignas(64) float weights[SHADOW_STRATA_MAX][SHADOW_STRATA_MAX]; /* of nodes; 0 from r on */
    int32_t first[SHADOW_STRATA_MAX];                                 /* node */
    const uint32_t *seen;
};

/* The field's numbers that loops over a pixel's strata and nodes read. */
struct project_shape {
    uint32_t strata, scale, window, lanes;
};

#ifdef __AVX512F__
/* Nodes whose sums stay in registers, four nodes in each. */
#define PROJECT_NODES 16

/* Sums four rows from `row` on at PROJECT_NODES nodes from `node` on, stratum by stratum. */
SIMD_INLINE void project_sum(const struct project_strata *s, uint32_t l, uint32_t row,
                             uint32_t node, __m512 sums[PROJECT_NODES / 4])
{
    const __m512i own = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    const __m512i most = _mm512_set1_epi32(SHADOW_STRATA_MAX);
    for (int k = 0; k < PROJECT_NODES / 4; k++) sums[k] = _mm512_setzero_ps();
    for (uint32_t a = 0; a < l; a++) {
        const __m256 low = _mm256_load_ps(s->weights[a]), high = _mm256_load_ps(s->weights[a] + 8);
        const __m512 weights = _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
        const __mmask16 seen = (__mmask16)((s->seen[a] >> row & 0xfu) * 0x1111u);
        const __m512i first = _mm512_add_epi32(own, _mm512_set1_epi32((int32_t)node - s->first[a]));
        for (int k = 0; k < PROJECT_NODES / 4; k++) {
            const __m512i at = _mm512_add_epi32(first, _mm512_set1_epi32(4 * k));
            sums[k] = _mm512_mask_add_ps(sums[k], _mm512_mask_cmplt_epu32_mask(seen, at, most),
                                         sums[k], _mm512_permutexvar_ps(at, weights));
        }
    }
}

/* Stores the sums of the nodes that there are, `stride` numbers apart. */
SIMD_INLINE void project_store(const __m512 sums[PROJECT_NODES / 4], uint32_t nodes,
                               uint32_t stride, float *node)
{
    for (uint32_t k = 0; k < PROJECT_NODES / 4 && 4 * k < nodes; k++) {
        float *to = node + (size_t)4 * k * stride;
        const uint32_t left = nodes - 4 * k;
        if (stride == 4 && left >= 4) {
            _mm512_storeu_ps(to, sums[k]);
            continue;
        }
        _mm_store_ps(to, _mm512_castps512_ps128(sums[k]));
        if (left > 1) _mm_store_ps(to + stride, _mm512_extractf32x4_ps(sums[k], 1));
        if (left > 2) _mm_store_ps(to + (size_t)2 * stride, _mm512_extractf32x4_ps(sums[k], 2));
        if (left > 3) _mm_store_ps(to + (size_t)3 * stride, _mm512_extractf32x4_ps(sums[k], 3));
    }
}

SIMD_INLINE void project_column(struct project_shape shape, const struct project_strata *s,
                                float *columns)
{
    const uint32_t used = 2 * shape.scale, lanes = shape.lanes;
    for (uint32_t row = 0; row < lanes; row += 4) {
        for (uint32_t n = 0; n < used; n += PROJECT_NODES) {
            __m512 sums[PROJECT_NODES / 4];
            project_sum(s, shape.strata, row, n, sums);
            project_store(sums, used - n, lanes, columns + (size_t)n * lanes + row);
        }
    }
    for (uint32_t i = 0; i < 2 * lanes; i += 4) /* no weight reaches the last two */
        *(shadow_four *)(columns + (size_t)used * lanes + i) = (shadow_four){0};
}
#else
/* 1 for each of four rows whose bit is set, else 0. */
static const _Alignas(16) float project_shares[16][4] = {
    {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 1, 0},
    {0, 1, 1, 0}, {1, 1, 1, 0}, {0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 1, 0, 1},
    {0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};

/* Adds weights[j] share to node j; nodes lie `stride` numbers apart. */
static inline void project_add(uint32_t count, const float *weights, const float *share,
                               uint32_t stride, float *node)
{
    const shadow_four four = *(const shadow_four *)share;
    for (uint32_t j = 0; j < count; j++, node += stride) *(shadow_four *)node += weights[j] * four;
}

SIMD_INLINE void project_column(struct project_shape shape, const struct project_strata *s,
                                float *columns)
{
    const uint32_t lanes = shape.lanes;
    memset(columns, 0, (2 * (size_t)shape.scale + 2) * lanes * sizeof *columns);
    for (uint32_t a = 0; a < shape.strata; a++) {
        float *node = columns + (size_t)s->first[a] * lanes;
        for (uint32_t b = 0; b < lanes; b += 4)
            project_add(shape.scale, s->weights[a], project_shares[s->seen[a] >> b & 0xfu], lanes,
                        node + b);
    }
}
#endif

#if defined __AVX__ && !defined __AVX512F__
#define PROJECT_BY_NODES 1
/* Sums up to PROJECT_FEW strata, whose rows and denominator fill four lanes: a register holds a
 * node's sums of two nodes. Weights have zeros around them for nodes that lie beyond: a stratum's
 * first node is `scale` at most, and the last one 2 scale - 1. */
#define PROJECT_FEW    3
#define PROJECT_BEFORE SHADOW_STRATA_MAX
#define PROJECT_SPAN   (PROJECT_BEFORE + 2 * SHADOW_STRATA_MAX)

struct project_group {
    _Alignas(64) float weights[PROJECT_GROUP][PROJECT_FEW][PROJECT_SPAN];
    int32_t first[PROJECT_GROUP][PROJECT_FEW]; /* nodes */
};
_Static_assert(SIMD_LANES % PROJECT_GROUP == 0, "groups begin where lanes do");

SIMD_INLINE void project_nodes(struct project_shape shape, float (*weights)[PROJECT_SPAN],
                               const int32_t *first, const uint32_t *seen, float *columns)
{
    const __m256i half = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
    const uint32_t used = 2 * shape.scale;
    const float *from[PROJECT_FEW];
    __m256 share[PROJECT_FEW];
    for (uint32_t a = 0; a < shape.strata; a++) {
        from[a] = weights[a] + PROJECT_BEFORE - first[a];
        share[a] = _mm256_broadcast_ps((const __m128 *)project_shares[seen[a] & 0xfu]);
    }
    for (uint32_t n = 0; n < used; n += 2) {
        __m256 sum = _mm256_setzero_ps();
        for (uint32_t a = 0; a < shape.strata; a++) {
            double two;
            memcpy(&two, from[a] + n, sizeof two);
            const __m256 both = _mm256_castpd_ps(_mm256_set1_pd(two));
            sum = _mm256_fmadd_ps(_mm256_permutevar_ps(both, half), share[a], sum);
        }
        _mm256_storeu_ps(columns + (size_t)n * 4, sum);
    }
    _mm256_storeu_ps(columns + (size_t)used * 4, _mm256_setzero_ps());
}

SIMD_INLINE void project_columns_few(const struct shadow_field *f, struct project_shape shape,
                                     const uint32_t *pixels, uint32_t count, const float *jitter,
                                     const uint32_t *seen)
{
    const uint32_t l = shape.strata, size = (2 * shape.scale + 2) * 4;
    struct project_start starts[PROJECT_FEW];
    struct project_group group = {0};
    for (uint32_t k = 0; k < count; k += PROJECT_GROUP) {
        const uint32_t left = count - k, many = left < PROJECT_GROUP ? left : PROJECT_GROUP;
        if (k % SIMD_LANES == 0) project_begin_all(f, l, jitter + k, left, starts);
        for (uint32_t i = 0; i < many; i++) {
            const struct project_row row = project_row_of(f, 0, pixels[k + i]);
            const uint32_t lane = k % SIMD_LANES + i;
            for (uint32_t a = 0; a < l; a++) {
                const struct project_start *s = &starts[a];
                group.first[i][a] = s->node[lane];
                project_weigh(&row, shape.window, s->below[lane], s->above[lane], s->g[lane],
                              s->rest[lane], group.weights[i][a] + PROJECT_BEFORE);
            }
        }
        for (uint32_t i = 0; i < many; i++)
            project_nodes(shape, group.weights[i], group.first[i], seen + (size_t)(k + i) * l,
                          f->columns + (size_t)f->pixels->slot[pixels[k + i]] * size);
    }
}
#endif

SIMD_INLINE void project_columns(const struct shadow_field *f, struct project_shape shape,
                                 const uint32_t *pixels, uint32_t count, const float *jitter,
                                 const uint32_t *seen)
{
    const uint32_t l = shape.strata, size = (2 * shape.scale + 2) * shape.lanes;
    struct project_start starts[SHADOW_STRATA_MAX];
    struct project_strata strata = {0};
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t lane = k % SIMD_LANES;
        const struct project_row row = project_row_of(f, 0, pixels[k]);
        if (lane == 0) project_begin_all(f, l, jitter + k, count - k, starts);
        for (uint32_t a = 0; a < l; a++) {
            const struct project_start *s = &starts[a];
            strata.first[a] = s->node[lane];
            project_weigh(&row, shape.window, s->below[lane], s->above[lane], s->g[lane],
                          s->rest[lane], strata.weights[a]);
        }
        strata.seen = seen + (size_t)k * l;
        project_column(shape, &strata, f->columns + (size_t)f->pixels->slot[pixels[k]] * size);
    }
}

/* Gives the compiler the usual number of strata as a constant, with which the loops are faster. */
SIMD_INLINE void project_columns_three(const struct shadow_field *f, struct project_shape three,
                                       const uint32_t *pixels, uint32_t count, const float *jitter,
                                       const uint32_t *seen)
{
#ifdef PROJECT_BY_NODES
    project_columns_few(f, three, pixels, count, jitter, seen);
#else
    project_columns(f, three, pixels, count, jitter, seen);
#endif
}

static void kernel_project_columns(const struct shadow_field *f, const uint32_t *pixels,
                                   uint32_t count, const float *jitter, const uint32_t *seen)
{
    static const struct project_shape three = {3, 8, 8, 4}, four = {4, 8, 8, 8};
    const struct project_shape shape = {f->strata, f->scale, f->window, f->lanes};
    if (memcmp(&shape, &three, sizeof shape) == 0)
        project_columns_three(f, three, pixels, count, jitter, seen);
    else if (memcmp(&shape, &four, sizeof shape) == 0)
        project_columns(f, four, pixels, count, jitter, seen);
    else
        project_columns(f, shape, pixels, count, jitter, seen);
}
