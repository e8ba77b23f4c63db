#pragma once
/* Neighbours of a pixel as arrays: from cache lines, one a neighbour, to one array a number. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "server/reconstruct/shadow_kernels.h"

#define SHADOW_LANES 16 /* arrays are filled up to a multiple of that */
/* Four sums side by side; they start on 16 bytes. */
typedef float shadow_four __attribute__((vector_size(16), may_alias));

struct shadow_lanes {
    _Alignas(64) int32_t to[SHADOW_LANES]; /* in: where, from the pixel */
    _Alignas(64) float number[SHADOW_NUMBERS][SHADOW_LANES];
};

#define LANES_QUADS 3 /* of four numbers, in a cache line */

static inline const float *lanes_line(const struct shadow_source *from, int32_t to)
{
    return (const float *)(const void *)(from + to);
}

/* Reads the first `quads` quads of numbers of as many neighbours as go at once, from the i-th on:
 * each line is looked up once. */
#ifdef __AVX2__
#define LANES_AT_ONCE 8
static inline __attribute__((always_inline)) void
lanes_take(const struct shadow_source *from, uint32_t quads, size_t i, struct shadow_lanes *out)
{
    const int32_t *to = out->to + i;
    __m256 a[LANES_QUADS][4];
    for (int k = 0; k < 4; k++) {
        const float *low = lanes_line(from, to[k]), *high = lanes_line(from, to[k + 4]);
        for (uint32_t q = 0; q < quads; q++)
            a[q][k] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(low + 4 * q)),
                                           _mm_load_ps(high + 4 * q), 1);
    }
    for (uint32_t q = 0; q < quads; q++) {
        const __m256 low01 = _mm256_unpacklo_ps(a[q][0], a[q][1]);
        const __m256 high01 = _mm256_unpackhi_ps(a[q][0], a[q][1]);
        const __m256 low23 = _mm256_unpacklo_ps(a[q][2], a[q][3]);
        const __m256 high23 = _mm256_unpackhi_ps(a[q][2], a[q][3]);
        _mm256_store_ps(out->number[4 * q] + i, _mm256_shuffle_ps(low01, low23, 0x44));
        _mm256_store_ps(out->number[4 * q + 1] + i, _mm256_shuffle_ps(low01, low23, 0xee));
        _mm256_store_ps(out->number[4 * q + 2] + i, _mm256_shuffle_ps(high01, high23, 0x44));
        _mm256_store_ps(out->number[4 * q + 3] + i, _mm256_shuffle_ps(high01, high23, 0xee));
    }
}
#else
#define LANES_AT_ONCE 1
static inline __attribute__((always_inline)) void
lanes_take(const struct shadow_source *from, uint32_t quads, size_t i, struct shadow_lanes *out)
{
    const float *line = lanes_line(from, out->to[i]);
    for (uint32_t k = 0; k < 4 * quads; k++) out->number[k][i] = line[k];
}
#endif

/* Points and normals of `count` neighbours from `from` on: number k of neighbour i at
 * out[k * stride + i]. */
static inline __attribute__((always_inline)) void
lanes_turn(const struct shadow_source *from, size_t count, size_t stride, float *out)
{
    size_t i = 0;
#ifdef __AVX2__
    while (count >= 8 && i < count) {
        const size_t left = count - i,
                     at = left < 8 ? count - 8 : i; /* the last turn may overlap */
        const struct shadow_source *line = from + at;
        float *to = out + at;
        __m256 a[4], b[4];
        for (int k = 0; k < 4; k++) {
            const float *low = lanes_line(line, k), *high = lanes_line(line, k + 4);
            a[k] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(low)), _mm_load_ps(high),
                                        1);
            b[k] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(low + 4)),
                                        _mm_load_ps(high + 4), 1);
        }
        const __m256 low01 = _mm256_unpacklo_ps(a[0], a[1]),
                     high01 = _mm256_unpackhi_ps(a[0], a[1]);
        const __m256 low23 = _mm256_unpacklo_ps(a[2], a[3]),
                     high23 = _mm256_unpackhi_ps(a[2], a[3]);
        const __m256 more01 = _mm256_unpacklo_ps(b[0], b[1]);
        const __m256 more23 = _mm256_unpacklo_ps(b[2], b[3]);
        _mm256_storeu_ps(to, _mm256_shuffle_ps(low01, low23, 0x44));
        _mm256_storeu_ps(to + stride, _mm256_shuffle_ps(low01, low23, 0xee));
        _mm256_storeu_ps(to + 2 * stride, _mm256_shuffle_ps(high01, high23, 0x44));
        _mm256_storeu_ps(to + 3 * stride, _mm256_shuffle_ps(high01, high23, 0xee));
        _mm256_storeu_ps(to + 4 * stride, _mm256_shuffle_ps(more01, more23, 0x44));
        _mm256_storeu_ps(to + 5 * stride, _mm256_shuffle_ps(more01, more23, 0xee));
        i = at + 8;
    }
#endif
    for (; i < count; i++) {
        const float *line = lanes_line(from, (int32_t)i);
        for (size_t k = 0; k < 6; k++) out[k * stride + i] = line[k];
    }
}

/* Writes the indices of the lanes that are not 0, in order; out has room for all. Returns how many.
 */
static inline size_t lanes_kept(const int32_t *lanes, size_t count, int32_t *out)
{
    size_t kept = 0;
#ifdef __AVX512F__
    __m512i at = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (size_t i = 0; i < count; i += 16, at = _mm512_add_epi32(at, _mm512_set1_epi32(16))) {
        const __m512i in = _mm512_load_si512(lanes + i);
        const __mmask16 set = _mm512_test_epi32_mask(in, in);
        _mm512_storeu_si512(out + kept, _mm512_maskz_compress_epi32(set, at));
        kept += (size_t)__builtin_popcount(set);
    }
#elif defined __AVX2__ && defined __BMI2__
    for (size_t i = 0; i < count; i += 8) {
        const __m256i in = _mm256_load_si256((const __m256i *)(const void *)(lanes + i));
        const __m256i none = _mm256_cmpeq_epi32(in, _mm256_setzero_si256());
        const uint32_t set = ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(none)) & 0xffu;
        const uint64_t bytes = _pdep_u64(set, 0x0101010101010101u) * 0xffu;
        const uint64_t at = _pext_u64(0x0706050403020100u, bytes);
        const __m256i wide = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)at));
        _mm256_storeu_si256((__m256i *)(void *)(out + kept),
                            _mm256_add_epi32(wide, _mm256_set1_epi32((int32_t)i)));
        kept += (size_t)__builtin_popcount(set);
    }
#else
    for (size_t i = 0; i < count; i++) {
        out[kept] = (int32_t)i;
        kept += lanes[i] != 0;
    }
#endif
    return kept;
}

/* Numbers 0 .. most - 1, `most` a multiple of 4, of the neighbours out->to of `from`. */
static inline __attribute__((always_inline)) void
lanes_fetch(const struct shadow_source *from, size_t count, uint32_t most, struct shadow_lanes *out)
{
    for (size_t i = 0; i < count; i += LANES_AT_ONCE) lanes_take(from, most / 4, i, out);
}

/* The sum over lanes in a fixed order, in pairs. Sums are kept in as many parts as there are lanes.
 */
static inline float lanes_sum(const float parts[SHADOW_LANES])
{
    typedef float four __attribute__((vector_size(16), aligned(4), may_alias));
    const four *in = (const four *)parts;
    const four sum = (in[0] + in[2]) + (in[1] + in[3]);
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

static void kernel_line_up(const struct shadow_source *sources, size_t count,
                           float *const planes[SHADOW_NUMBERS])
{
    struct shadow_lanes lanes;
    for (size_t first = 0; first < count; first += SHADOW_LANES) {
        const size_t left = count - first, n = left < SHADOW_LANES ? left : SHADOW_LANES;
        for (size_t i = 0; i < SHADOW_LANES; i++) lanes.to[i] = (int32_t)(i < n ? i : n - 1);
        lanes_fetch(sources + first, SHADOW_LANES, SHADOW_NUMBERS, &lanes);
        for (size_t k = 0; k < SHADOW_NUMBERS; k++)
            memcpy(planes[k] + first, lanes.number[k], n * sizeof *planes[k]);
    }
}
