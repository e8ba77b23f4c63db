#pragma once
/* What a pixel's taps give, summed one after the other: its cells from columns, its share from
 * rows.
 */
#include <string.h>

#include "server/reconstruct/walk_taps_lanes.h"

/* The taps that lane i has: from *first to before *end. */
static inline void walk_span(const struct walk_taps *taps, uint32_t i, int32_t *first, int32_t *end)
{
    const int32_t centre = 2 * taps->group.reach_most, most = 2 * taps->group.reach[i];
    *first = centre - most;
    *end = centre + most + 2;
}

/* To the sums of each phase what two neighbouring nodes of lane i's taps give. */
static inline void walk_add(const struct shadow_field *f, uint32_t lanes,
                            const struct walk_taps *taps, uint32_t i, float *sums)
{
    int32_t first, end;
    walk_span(taps, i, &first, &end);
    for (int32_t n = first; n < end; n++) {
        const float *c = f->columns + taps->at[n][i], *w = taps->weight[n] + 2 * (size_t)i;
        float *to = sums + taps->phase[n][i];
        for (uint32_t b = 0; b < lanes; b += 4)
            *(shadow_four *)(to + b) +=
                w[0] * *(const shadow_four *)(c + b) + w[1] * *(const shadow_four *)(c + lanes + b);
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

#ifdef __AVX512F__

/* Nine samples a light have 16 phases: each of four sums is a register of all phases, to whose one
 * a tap adds. In memory, at places that nobody can foretell, the CPU would wait for what it has
 * just written. */
static inline void walk_add_three(const struct shadow_field *f, const struct walk_taps *taps,
                                  uint32_t i, __m512 sums[4])
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i places = _mm512_slli_epi32(lane, 2);
    int32_t first, end;
    walk_span(taps, i, &first, &end);
    for (int32_t b = 0; b < 4; b++) sums[b] = _mm512_setzero_ps();
    for (int32_t n = first; n < end; n++) {
        const float *c = f->columns + taps->at[n][i], *w = taps->weight[n] + 2 * (size_t)i;
        const __m128 four = _mm_add_ps(_mm_mul_ps(_mm_set1_ps(w[0]), _mm_load_ps(c)),
                                       _mm_mul_ps(_mm_set1_ps(w[1]), _mm_load_ps(c + 4)));
        __builtin_prefetch(f->columns + taps->at[n][(i + 1) % SHADOW_LANES]);
        const __m512 all = _mm512_broadcast_f32x4(four);
        const __mmask16 phase =
            _mm512_cmpeq_epi32_mask(places, _mm512_set1_epi32((int32_t)taps->phase[n][i]));
        sums[0] = _mm512_mask_add_ps(sums[0], phase, sums[0], _mm512_permute_ps(all, 0x00));
        sums[1] = _mm512_mask_add_ps(sums[1], phase, sums[1], _mm512_permute_ps(all, 0x55));
        sums[2] = _mm512_mask_add_ps(sums[2], phase, sums[2], _mm512_permute_ps(all, 0xaa));
        sums[3] = _mm512_mask_add_ps(sums[3], phase, sums[3], _mm512_permute_ps(all, 0xff));
    }
}

/* Number 3 c + k, counted row by row, for all cells c: from three rows, and from a row that is the
 * same for all. */
static inline void walk_pick(const __m512 sums[4], int32_t k, __m512 *numerator,
                             __m512 *denominator)
{
    const __m512i threes =
        _mm512_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 42, 45);
    const __m512i at = _mm512_add_epi32(threes, _mm512_set1_epi32(k));
    const __mmask16 last = _mm512_cmpge_epi32_mask(at, _mm512_set1_epi32(32));
    const __m512 two = _mm512_permutex2var_ps(sums[0], at, sums[1]);
    *numerator = _mm512_mask_permutexvar_ps(two, last, at, sums[2]);
    *denominator = _mm512_permutexvar_ps(at, sums[3]);
}

static inline void walk_sum_three(const struct shadow_field *f, const struct walk_taps *taps,
                                  uint32_t i, float *out)
{
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    __m512 sums[4], n[3], d[3];
    walk_add_three(f, taps, i, sums);
    for (int32_t k = 0; k < 3; k++) walk_pick(sums, k, &n[k], &d[k]);
    const __m512 numerator = _mm512_add_ps(_mm512_add_ps(n[0], n[1]), n[2]);
    const __m512 denominator = _mm512_add_ps(_mm512_add_ps(d[0], d[1]), d[2]);
    _mm512_storeu_ps(out, _mm512_permutex2var_ps(numerator, low, denominator));
    _mm512_storeu_ps(out + 16, _mm512_permutex2var_ps(numerator, high, denominator));
}

#else

/* The same in memory. */
static inline void walk_sum_three(const struct shadow_field *f, const struct walk_taps *taps,
                                  uint32_t i, float *out)
{
    _Alignas(16) float sums[16][4] = {{0}};
    walk_add(f, 4, taps, i, sums[0]);
#pragma GCC unroll 16
    for (uint32_t c = 0; c < 16; c++) {
        const uint32_t j = 3 * c, k = j + 1, l = j + 2;
        out[2 * c] = sums[j & 15][j >> 4] + sums[k & 15][k >> 4] + sums[l & 15][l >> 4];
        out[2 * c + 1] = sums[j & 15][3] + sums[k & 15][3] + sums[l & 15][3];
    }
}

#endif

static inline void walk_sum_columns(const struct shadow_field *f, const struct walk_taps *taps,
                                    uint32_t i, float *out)
{
    if (f->strata == 3) {
        walk_sum_three(f, taps, i, out);
        return;
    }
    _Alignas(64) float sums[SHADOW_SUMS_MAX];
    memset(sums, 0, f->phases * f->lanes * sizeof *sums);
    walk_add(f, f->lanes, taps, i, sums);
    walk_cells(f, sums, out);
}

/* What tap n gives: two nodes' (numerator, denominator), weighted. */
static inline shadow_four walk_nodes(const struct shadow_field *f, const struct walk_taps *taps,
                                     int32_t n, uint32_t i)
{
    const float *w = taps->weight[n] + 2 * (size_t)i;
    shadow_four nodes; /* they start on 8 bytes */
    memcpy(&nodes, f->rows + taps->at[n][i], sizeof nodes);
    return nodes * (shadow_four){w[0], w[0], w[1], w[1]};
}

static inline void walk_sum_rows(const struct shadow_field *f, const struct walk_taps *taps,
                                 uint32_t i, float out[2])
{
    int32_t first, end;
    shadow_four even = {0}, odd = {0}; /* two sums: their additions overlap */
    walk_span(taps, i, &first, &end);
    for (int32_t n = first; n < end; n += 2) {
        even += walk_nodes(f, taps, n, i);
        odd += walk_nodes(f, taps, n + 1, i);
    }
    const shadow_four all = even + odd;
    out[0] = all[0] + all[2];
    out[1] = all[1] + all[3];
}
