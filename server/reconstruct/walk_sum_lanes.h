#pragma once
/* What the taps of sixteen pixels give: their cells from columns, their shares from rows. One tap
 * of all pixels comes after the other: what a pixel's next tap adds to has long been written then,
 * and sums of several pixels do not wait for each other. A pixel's own are added in their order. */
#include <string.h>

#include "server/reconstruct/fused.h"
#include "server/reconstruct/lanes_inline.h"
#include "server/reconstruct/walk_taps_lanes.h"

typedef float walk_two __attribute__((vector_size(8)));

static inline walk_two walk_weights(const struct walk_taps *taps, int32_t n, uint32_t i)
{
    walk_two w;
    memcpy(&w, taps->weight[n] + 2 * (size_t)i, sizeof w);
    return w;
}

static inline double walk_as_double(walk_two w)
{
    double bits;
    memcpy(&bits, &w, sizeof bits);
    return bits;
}

/* Four sums of a node and those of the next one, which lies `lanes` on, weighted. */
LANES_INLINE shadow_four walk_between(const float *node, uint32_t lanes, walk_two w)
{
#ifdef __AVX__
    if (lanes == 4) { /* one piece of memory: loads are what the loop takes */
        const __m256i half = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
        const __m256 weights = _mm256_castpd_ps(_mm256_set1_pd(walk_as_double(w)));
        const __m256 both =
            _mm256_mul_ps(_mm256_loadu_ps(node), _mm256_permutevar_ps(weights, half));
        return (shadow_four)(_mm256_castps256_ps128(both) + _mm256_extractf128_ps(both, 1));
    }
#endif
    return w[0] * *(const shadow_four *)node + w[1] * *(const shadow_four *)(node + lanes);
}

/* To the sums of each phase of each pixel what two neighbouring nodes give. Taps that a pixel does
 * not have weigh nothing. */
LANES_INLINE void walk_add(const struct shadow_field *f, uint32_t lanes,
                           const struct walk_taps *taps, float *sums)
{
    const int32_t count = walk_group_taps(&taps->group);
    for (int32_t n = 0; n < count; n++) {
#pragma GCC unroll 4
        for (uint32_t i = 0; i < SHADOW_LANES; i++) {
            const float *c = f->columns + taps->at[n][i];
            float *to = sums + taps->phase[n][i];
            const walk_two w = walk_weights(taps, n, i);
            for (uint32_t b = 0; b < lanes; b += 4)
                *(shadow_four *)(to + b) += walk_between(c + b, lanes, w);
        }
    }
}

/* From sums a phase to (numerator, denominator) a cell. */
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

/* The same of nine samples a light: 16 phases of three rows and a denominator, 16 cells of three
 * numbers that follow each other row by row. */

#ifdef __AVX512F__

/* Sums at[0] .. at[15] of 64. */
static inline __m512 walk_pick(const __m512 sums[4], lanes_mask at)
{
    const __m512i places = (__m512i)at;
    const __m512 low = _mm512_permutex2var_ps(sums[0], places, sums[1]);
    const __m512 high = _mm512_permutex2var_ps(sums[2], places, sums[3]);
    return _mm512_mask_mov_ps(low, _mm512_cmpgt_epi32_mask(places, _mm512_set1_epi32(31)), high);
}

static inline void walk_cells_three(const float *sums, float *out)
{
    const lanes_mask cell = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    __m512 in[4], n[3], d[3];
    for (int r = 0; r < 4; r++) in[r] = _mm512_load_ps(sums + r * 16);
    for (int k = 0; k < 3; k++) {
        const lanes_mask number = 3 * cell + k, phase = number & 15;
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
    const float(*in)[4] = (const float(*)[4])sums;
#pragma GCC unroll 16
    for (uint32_t c = 0; c < 16; c++) {
        const uint32_t j = 3 * c, k = j + 1, l = j + 2;
        out[2 * c] = in[j & 15][j >> 4] + in[k & 15][k >> 4] + in[l & 15][l >> 4];
        out[2 * c + 1] = in[j & 15][3] + in[k & 15][3] + in[l & 15][3];
    }
}

#endif

/* Cells of the group's pixels, 4 r numbers each. */
static inline void walk_sum_columns(const struct shadow_field *f, const struct walk_taps *taps,
                                    float *out)
{
    const size_t each = f->phases * f->lanes; /* SHADOW_SUMS_MAX at most */
    const uint32_t pixels = taps->group.count;
    _Alignas(64) float sums[SHADOW_LANES * SHADOW_SUMS_MAX];
    memset(sums, 0, SHADOW_LANES * each * sizeof *sums);
    if (f->strata == 3) {
        walk_add(f, 4, taps, sums);
        for (uint32_t i = 0; i < pixels; i++) walk_cells_three(sums + i * each, out + i * 32);
        return;
    }
    walk_add(f, f->lanes, taps, sums);
    for (uint32_t i = 0; i < pixels; i++)
        walk_cells(f, sums + i * each, out + (size_t)i * 4 * f->scale);
}

/* Pixels whose sums fit into registers. */
#ifdef __AVX512F__
#define WALK_ROWS 8
#else
#define WALK_ROWS 4
#endif

/* Adds what tap n of pixel i gives: two nodes' (numerator, denominator), weighted. */
static inline shadow_four walk_nodes(const struct shadow_field *f, const struct walk_taps *taps,
                                     int32_t n, uint32_t i, shadow_four sum)
{
    const walk_two w = walk_weights(taps, n, i);
    shadow_four nodes; /* they start on 8 bytes */
    memcpy(&nodes, f->rows + taps->at[n][i], sizeof nodes);
    return fused_4(nodes, __builtin_shufflevector(w, w, 0, 0, 1, 1), sum);
}

/* Of WALK_ROWS pixels from `first` on. */
static inline void walk_sum_few(const struct shadow_field *f, const struct walk_taps *taps,
                                uint32_t first, shadow_four all[WALK_ROWS])
{
    const int32_t count = walk_group_taps(&taps->group);
    shadow_four even[WALK_ROWS] = {{0}}, odd[WALK_ROWS] = {{0}};
    for (int32_t n = 0; n < count; n += 2) {
#pragma GCC unroll 8
        for (uint32_t i = 0; i < WALK_ROWS; i++) {
            even[i] = walk_nodes(f, taps, n, first + i, even[i]);
            odd[i] = walk_nodes(f, taps, n + 1, first + i, odd[i]);
        }
    }
    for (uint32_t i = 0; i < WALK_ROWS; i++) all[i] = even[i] + odd[i];
}

/* (numerator, denominator) of the group's pixels. */
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
