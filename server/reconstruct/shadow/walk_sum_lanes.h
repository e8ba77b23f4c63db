#pragma once
/* Sums what the taps of sixteen pixels contribute: cells from columns, shares from rows. The loop
 * runs over taps outside and over pixels inside, so that a sum is complete in memory before the
 * pixel's next tap adds to it. A pixel's taps are added in their order. */
#include <string.h>

#include "server/reconstruct/shadow/walk_taps_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/inline.h"

typedef float walk_two __attribute__((vector_size(8), may_alias));

/* Adds two neighbouring nodes to the sums of each phase of each pixel. Missing taps weigh 0. */
SIMD_INLINE void walk_add(const struct shadow_field *f, uint32_t lanes,
                          const struct walk_taps *taps, uint32_t n, float *sums)
{
#pragma GCC unroll 4
    for (uint32_t i = 0; i < SIMD_LANES; i++) {
        const float *c = f->columns + taps->at[n][i];
        float *to = sums + taps->phase[n][i];
        const walk_two w = ((const walk_two *)taps->weight[n])[i];
        for (uint32_t b = 0; b < lanes; b += 4)
            *(shadow_four *)(to + b) +=
                w[0] * *(const shadow_four *)(c + b) + w[1] * *(const shadow_four *)(c + lanes + b);
    }
}

SIMD_INLINE void walk_add_steps(const struct shadow_field *f, uint32_t lanes,
                                const struct walk_taps *taps, float *sums)
{
    for (uint32_t s = 0; s < taps->steps; s++) {
        walk_add(f, lanes, taps, taps->first[s], sums);
        walk_add(f, lanes, taps, taps->first[s] + 1, sums);
    }
}

/* Loads pair i of a tap's weights, each of them four times. The load may pass the last pair, but
 * not struct walk_taps. */
SIMD_INLINE void walk_weights(const float *pairs, uint32_t i, fused_eight *w)
{
#ifdef __AVX2__
    const __m256i half = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
    *w = (fused_eight)_mm256_permutevar8x32_ps(_mm256_loadu_ps(pairs + 2 * (size_t)i), half);
#else
    const walk_two pair = ((const walk_two *)pairs)[i];
    *w = __builtin_shufflevector(pair, pair, 0, 0, 0, 0, 1, 1, 1, 1);
#endif
}

/* Does the same for nodes of four numbers: both are added to eight sums. */
static inline void walk_add_both(const struct shadow_field *f, const struct walk_taps *taps,
                                 uint32_t n, float *sums)
{
    const uint32_t *at = taps->at[n], *phase = taps->phase[n];
    const float *pairs = taps->weight[n];
#pragma GCC unroll 16
    for (uint32_t i = 0; i < SIMD_LANES; i++) {
        fused_eight w;
        walk_weights(pairs, i, &w);
        fused_add_8((const fused_eight *)(f->columns + at[i]), &w,
                    (fused_eight *)(sums + phase[i]));
    }
}

static inline void walk_add_steps_both(const struct shadow_field *f, const struct walk_taps *taps,
                                       float *sums)
{
    for (uint32_t s = 0; s < taps->steps; s++) {
        walk_add_both(f, taps, taps->first[s], sums);
        walk_add_both(f, taps, taps->first[s] + 1, sums);
    }
}

/* Turns sums by phase into (numerator, denominator) by cell. */
static inline void walk_cells(const struct shadow_field *f, const float *sums, float *out)
{
    const uint32_t l = f->strata, cells = 2 * f->scale, each = l * f->phases / cells;
    uint32_t phase = 0, row = 0;
    for (uint32_t c = 0; c < cells; c++) {
        float numerator = 0.0f, denominator = 0.0f;
        for (uint32_t k = 0; k < each; k++) {
            numerator += sums[phase * f->lanes + row];
            denominator += sums[phase * f->lanes + l];
            if (++phase == f->phases) {
                phase = 0;
                row++;
            }
        }
        out[2 * c] = numerator;
        out[2 * c + 1] = denominator;
    }
}

/* Does the same for nine samples a light: 16 phases of three rows and a denominator become 16
 * cells, whose three numbers follow each other row by row. */

#ifdef __AVX512F__

/* Returns sums at[0] .. at[15] of 64. */
static inline __m512 walk_pick(const __m512 sums[4], simd_mask at)
{
    const __m512i places = (__m512i)at;
    const __m512 low = _mm512_permutex2var_ps(sums[0], places, sums[1]);
    const __m512 high = _mm512_permutex2var_ps(sums[2], places, sums[3]);
    return _mm512_mask_mov_ps(low, _mm512_cmpgt_epi32_mask(places, _mm512_set1_epi32(31)), high);
}

/* Returns four phases' sums of both nodes. */
static inline __m512 walk_four_phases(const float *sums)
{
    const __m512 low = _mm512_load_ps(sums), high = _mm512_load_ps(sums + 16);
    return _mm512_add_ps(_mm512_shuffle_f32x4(low, high, 0x88),
                         _mm512_shuffle_f32x4(low, high, 0xdd));
}

static inline void walk_cells_three(const float *sums, float *out)
{
    const simd_mask cell = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    __m512 in[4], n[3], d[3];
    for (int r = 0; r < 4; r++) in[r] = walk_four_phases(sums + (size_t)r * 32);
    for (int k = 0; k < 3; k++) {
        const simd_mask number = 3 * cell + k, phase = number & 15;
        n[k] = walk_pick(in, 4 * phase + (number >> 4));
        d[k] = walk_pick(in, 4 * phase + 3);
    }
    const __m512 numerator = _mm512_add_ps(_mm512_add_ps(n[0], n[1]), n[2]);
    const __m512 denominator = _mm512_add_ps(_mm512_add_ps(d[0], d[1]), d[2]);
    _mm512_storeu_ps(out, _mm512_permutex2var_ps(numerator, low, denominator));
    _mm512_storeu_ps(out + 16, _mm512_permutex2var_ps(numerator, high, denominator));
}

#else

static inline void walk_cells_three(const float *sums, float *out)
{
    float in[16][4];
    for (size_t k = 0; k < 16; k++)
        *(fused_four *)in[k] =
            *(const fused_four *)(sums + 8 * k) + *(const fused_four *)(sums + 8 * k + 4);
#pragma GCC unroll 16
    for (uint32_t c = 0; c < 16; c++) {
        const uint32_t j = 3 * c, k = j + 1, l = j + 2;
        out[2 * c] = in[j & 15][j >> 4] + in[k & 15][k >> 4] + in[l & 15][l >> 4];
        out[2 * c + 1] = in[j & 15][3] + in[k & 15][3] + in[l & 15][3];
    }
}

#endif

/* Computes the cells of the group's pixels, 4 r numbers each. */
static inline void walk_sum_columns(const struct shadow_field *f, const struct walk_taps *taps,
                                    float *out)
{
    const size_t each = f->phases * walk_phase_sums(f); /* SHADOW_SUMS_MAX at most */
    const uint32_t pixels = taps->group.count;
    _Alignas(64) float sums[SIMD_LANES * SHADOW_SUMS_MAX];
    memset(sums, 0, SIMD_LANES * each * sizeof *sums);
    if (f->strata == 3) {
        walk_add_steps_both(f, taps, sums);
        for (uint32_t i = 0; i < pixels; i++) walk_cells_three(sums + i * each, out + i * 32);
        return;
    }
    walk_add_steps(f, f->lanes, taps, sums);
    for (uint32_t i = 0; i < pixels; i++)
        walk_cells(f, sums + i * each, out + (size_t)i * 4 * f->scale);
}

/* Pixels whose sums fit into registers. */
#ifdef __AVX512F__
#define WALK_ROWS 8
#else
#define WALK_ROWS 4
#endif

/* Adds a tap's two nodes of (numerator, denominator), weighted. They are aligned to 8 bytes. */
static inline shadow_four walk_nodes(const float *nodes, walk_two w, shadow_four sum)
{
    return fused_4(*(const fused_four *)nodes, __builtin_shufflevector(w, w, 0, 0, 1, 1), sum);
}

/* Sums WALK_ROWS pixels from `first` on. */
static inline void walk_sum_few(const struct shadow_field *f, const struct walk_taps *taps,
                                uint32_t first, shadow_four all[WALK_ROWS])
{
    const float *rows = f->rows;
    shadow_four even[WALK_ROWS] = {{0}}, odd[WALK_ROWS] = {{0}};
    for (uint32_t s = 0; s < taps->steps; s++) {
        const uint32_t n = taps->first[s];
        const walk_two *w = (const walk_two *)taps->weight[n] + first;
        const uint32_t *at = taps->at[n] + first;
#pragma GCC unroll 8
        for (uint32_t i = 0; i < WALK_ROWS; i++) {
            even[i] = walk_nodes(rows + at[i], w[i], even[i]);
            odd[i] = walk_nodes(rows + at[SIMD_LANES + i], w[SIMD_LANES + i], odd[i]);
        }
    }
    for (uint32_t i = 0; i < WALK_ROWS; i++) all[i] = even[i] + odd[i];
}

/* Computes (numerator, denominator) of the group's pixels. */
static inline void walk_sum_rows(const struct shadow_field *f, const struct walk_taps *taps,
                                 float *out)
{
    const uint32_t pixels = taps->group.count;
    for (uint32_t first = 0; first < pixels; first += WALK_ROWS) {
        shadow_four all[WALK_ROWS];
        walk_sum_few(f, taps, first, all);
        for (uint32_t i = 0; i < WALK_ROWS && first + i < pixels; i++) {
            out[2 * (first + i)] = all[i][0] + all[i][2];
            out[2 * (first + i) + 1] = all[i][1] + all[i][3];
        }
    }
}
