#pragma once
/* Loads and stores numbers of sixteen pixels, from and to planes. The pixels of a list are mostly
 * adjacent, and so are their taps: then one vector load reads a number of all of them. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "server/reconstruct/shadow/shadow_kernels.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/lanes.h"

/* Four sums, aligned to 16 bytes. */
typedef float shadow_four __attribute__((vector_size(16), may_alias));

/* simd_take copies out[n][i] = planes[n][to[i]] for `count` planes of float or int32_t, as bits.
 * simd_put copies planes[n][to[i]] = numbers[n][i]; pixels may repeat where their numbers are
 * equal. Nothing else of the planes is read or written. */

#ifdef __AVX512F__

/* Returns the lanes of `left`, which is not 0, whose pixels follow each other as the lanes do.
 * *start becomes lane 0's pixel. */
static inline __mmask16 simd_run(__m512i to, __mmask16 left, ptrdiff_t *start)
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i from = _mm512_sub_epi32(to, lane);
    const __m128i first = _mm512_castsi512_si128(_mm512_maskz_compress_epi32(left, from));
    *start = _mm_cvtsi128_si32(first);
    return _mm512_mask_cmpeq_epi32_mask(left, from, _mm512_broadcastd_epi32(first));
}

SIMD_INLINE void simd_take(const void *const *planes, size_t count, const int32_t to[SIMD_LANES],
                           float out[][SIMD_LANES])
{
    const __m512i pixels = _mm512_loadu_si512(to);
    ptrdiff_t start;
    __mmask16 left = 0xffff, run = simd_run(pixels, left, &start);
    for (size_t n = 0; n < count; n++)
        _mm512_storeu_ps(out[n], _mm512_maskz_loadu_ps(run, (const float *)planes[n] + start));
    while ((left &= (__mmask16)~run) != 0) {
        run = simd_run(pixels, left, &start);
        for (size_t n = 0; n < count; n++) {
            const __m512 others = _mm512_loadu_ps(out[n]);
            _mm512_storeu_ps(out[n],
                             _mm512_mask_loadu_ps(others, run, (const float *)planes[n] + start));
        }
    }
}

SIMD_INLINE void simd_put(void *const *planes, size_t count, const int32_t to[SIMD_LANES],
                          const void *numbers)
{
    const float *in = numbers;
    const __m512i pixels = _mm512_loadu_si512(to);
    for (__mmask16 left = 0xffff, run; left != 0; left &= (__mmask16)~run) {
        ptrdiff_t start;
        run = simd_run(pixels, left, &start);
        for (size_t n = 0; n < count; n++)
            _mm512_mask_storeu_ps((float *)planes[n] + start, run,
                                  _mm512_loadu_ps(in + n * SIMD_LANES));
    }
}

#else
#ifdef __AVX2__

/* Does the same for eight lanes; `left` is a mask in a vector's lanes. */
static inline __m256i simd_run(__m256i to, __m256i left, ptrdiff_t *start)
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const uint32_t first =
        (uint32_t)__builtin_ctz((uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(left)));
    const __m256i from = _mm256_sub_epi32(to, lane);
    const __m256i all = _mm256_permutevar8x32_epi32(from, _mm256_set1_epi32((int32_t)first));
    *start = _mm256_cvtsi256_si32(all);
    return _mm256_and_si256(left, _mm256_cmpeq_epi32(from, all));
}

SIMD_INLINE void simd_take_eight(const void *const *planes, size_t count, size_t half,
                                 const int32_t to[SIMD_LANES], float out[][SIMD_LANES])
{
    const __m256i pixels = _mm256_loadu_si256((const __m256i *)(const void *)(to + half));
    ptrdiff_t start;
    __m256i left = _mm256_set1_epi32(-1), run = simd_run(pixels, left, &start);
    if (_mm256_testc_si256(run, left)) { /* all: the common case */
        for (size_t n = 0; n < count; n++)
            _mm256_storeu_ps(out[n] + half, _mm256_loadu_ps((const float *)planes[n] + start));
        return;
    }
    for (size_t n = 0; n < count; n++)
        _mm256_storeu_ps(out[n] + half, _mm256_maskload_ps((const float *)planes[n] + start, run));
    for (;;) {
        left = _mm256_andnot_si256(run, left);
        if (_mm256_testz_si256(left, left)) break;
        run = simd_run(pixels, left, &start);
        for (size_t n = 0; n < count; n++) {
            const __m256 others = _mm256_loadu_ps(out[n] + half);
            const __m256 more = _mm256_maskload_ps((const float *)planes[n] + start, run);
            _mm256_storeu_ps(out[n] + half, _mm256_or_ps(others, more)); /* 0 where they are not */
        }
    }
}

SIMD_INLINE void simd_take(const void *const *planes, size_t count, const int32_t to[SIMD_LANES],
                           float out[][SIMD_LANES])
{
    simd_take_eight(planes, count, 0, to, out);
    simd_take_eight(planes, count, SIMD_LANES / 2, to, out);
}

#else

SIMD_INLINE void simd_take(const void *const *planes, size_t count, const int32_t to[SIMD_LANES],
                           float out[][SIMD_LANES])
{
    for (uint32_t first = 0; first < SIMD_LANES; first += 4) {
        const int32_t *at = to + first;
        const int follows = (at[1] == at[0] + 1) & (at[2] == at[0] + 2) & (at[3] == at[0] + 3);
        for (size_t n = 0; n < count; n++) {
            const float *plane = planes[n];
            float *own = out[n] + first;
            if (follows)
                memcpy(own, plane + at[0], 4 * sizeof *own);
            else
                for (uint32_t i = 0; i < 4; i++) memcpy(own + i, plane + at[i], sizeof *own);
        }
    }
}

#endif

/* Lanes that are stored with one instruction where their pixels are adjacent. */
#ifdef __AVX2__
#define SIMD_STORED 8
#else
#define SIMD_STORED 16
#endif

static inline bool simd_stored_follow(const int32_t to[SIMD_STORED])
{
#ifdef __AVX2__
    const __m256i pixels = _mm256_loadu_si256((const __m256i *)(const void *)to);
    const __m256i all = _mm256_set1_epi32(-1);
    ptrdiff_t start;
    return _mm256_testc_si256(simd_run(pixels, all, &start), all);
#else
    int32_t follows = 1;
    for (int32_t i = 1; i < SIMD_STORED; i++) follows &= to[i] == to[0] + i;
    return follows;
#endif
}

SIMD_INLINE void simd_put(void *const *planes, size_t count, const int32_t to[SIMD_LANES],
                          const void *numbers)
{
    for (uint32_t first = 0; first < SIMD_LANES; first += SIMD_STORED) {
        const float *in = (const float *)numbers + first;
        const int32_t *at = to + first;
        if (simd_stored_follow(at)) {
            for (size_t n = 0; n < count; n++, in += SIMD_LANES)
                memcpy((float *)planes[n] + at[0], in, SIMD_STORED * sizeof *in);
            continue;
        }
        for (size_t n = 0; n < count; n++, in += SIMD_LANES)
            for (uint32_t i = 0; i < SIMD_STORED; i++)
                memcpy((float *)planes[n] + at[i], in + i, sizeof *in);
    }
}

#endif

/* A number of a plane: a float, or the bits of an integer. */
typedef float simd_number __attribute__((may_alias));

/* Returns whether the pixels are adjacent, in the order of the lanes; then *start is the first. */
static inline bool simd_follow(const int32_t to[SIMD_LANES], ptrdiff_t *start)
{
    int32_t follows = 1;
    *start = to[0];
#ifdef __AVX512F__
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i first = _mm512_add_epi32(_mm512_set1_epi32(to[0]), lane);
    follows = _mm512_cmpneq_epi32_mask(_mm512_loadu_si512(to), first) == 0;
#elif defined __AVX2__
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), eight = _mm256_set1_epi32(8);
    const __m256i *in = (const __m256i *)(const void *)to;
    const __m256i low = _mm256_add_epi32(_mm256_set1_epi32(to[0]), lane);
    const __m256i off =
        _mm256_or_si256(_mm256_xor_si256(_mm256_loadu_si256(in), low),
                        _mm256_xor_si256(_mm256_loadu_si256(in + 1), _mm256_add_epi32(low, eight)));
    follows = _mm256_testz_si256(off, off);
#else
    for (int32_t i = 1; i < SIMD_LANES; i++) follows &= to[i] == to[0] + i;
#endif
    return follows;
}

/* Loads the pixels of a list into lanes. Lanes past the list's end repeat the last pixel. */
SIMD_INLINE void simd_list(const uint32_t *pixels, uint32_t count, int32_t out[SIMD_LANES])
{
    if (count >= SIMD_LANES) { /* Copied in one piece: a vector load would stall on several stores
                                    in flight. */
        memcpy(out, pixels, SIMD_LANES * sizeof *out);
        return;
    }
    for (uint32_t i = 0; i < SIMD_LANES; i++) out[i] = (int32_t)pixels[i < count ? i : count - 1];
}

/* Writes the indices of the lanes that are not 0, in order; out has room for all. Returns how many
 * there are. */
static inline size_t simd_kept(const int32_t *lanes, size_t count, int32_t *out)
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

/* Returns v if kept is 1, and 0 if it is 0. For a conditional gcc may emit a branch or a masked
 * store, which is slow where v takes long to compute or is stored to where it was read. */
static inline float simd_keep(int32_t kept, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    bits &= (uint32_t)-kept;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Returns the sum over lanes, in pairs and in a fixed order. Sums are kept in as many parts as
 * there are lanes. */
static inline float simd_sum(const float parts[SIMD_LANES])
{
    typedef float four __attribute__((vector_size(16), aligned(4), may_alias));
    const four *in = (const four *)parts;
    const four sum = (in[0] + in[2]) + (in[1] + in[3]);
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}
