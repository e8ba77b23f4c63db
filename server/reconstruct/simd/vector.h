#pragma once
/* Sixteen numbers side by side, in the registers of whatever instruction set the including file is
 * compiled for. Plain operators work on their vectors. A comparison gives a mask. Named ones give
 * simd_chosen, for which AVX-512 has registers of its own. */
#include <stdint.h>

#include <immintrin.h>

#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/lanes.h"

#ifdef __AVX512F__
#define SIMD_VECTOR_BYTES 64
#elif defined __AVX__
#define SIMD_VECTOR_BYTES 32
#else
#define SIMD_VECTOR_BYTES 16
#endif
#define SIMD_VECTORS    (SIMD_LANES * 4 / SIMD_VECTOR_BYTES)
#define SIMD_PER_VECTOR (SIMD_VECTOR_BYTES / 4)

typedef float simd_vector __attribute__((vector_size(SIMD_VECTOR_BYTES)));
typedef int32_t simd_mask __attribute__((vector_size(SIMD_VECTOR_BYTES))); /* 0 or -1 */

/* The same vectors, anywhere in memory. */
typedef float simd_stored __attribute__((vector_size(SIMD_VECTOR_BYTES), aligned(4), may_alias));
typedef int32_t simd_stored_mask
    __attribute__((vector_size(SIMD_VECTOR_BYTES), aligned(4), may_alias));

struct simd {
    simd_vector v[SIMD_VECTORS];
};

struct simd_whole {
    simd_mask v[SIMD_VECTORS];
};

static inline simd_vector simd_load_vector(const float *from)
{
    return *(const simd_stored *)from;
}

static inline simd_mask simd_load_mask(const int32_t *from)
{
    return *(const simd_stored_mask *)from;
}

static inline struct simd simd_load(const float *from)
{
    struct simd out;
    for (int v = 0; v < SIMD_VECTORS; v++) out.v[v] = simd_load_vector(from + v * SIMD_PER_VECTOR);
    return out;
}

static inline struct simd_whole simd_load_whole(const int32_t *from)
{
    struct simd_whole out;
    for (int v = 0; v < SIMD_VECTORS; v++) out.v[v] = simd_load_mask(from + v * SIMD_PER_VECTOR);
    return out;
}

static inline void simd_store(const struct simd *from, float *to)
{
    simd_stored *vectors = (simd_stored *)to;
    for (int v = 0; v < SIMD_VECTORS; v++) vectors[v] = from->v[v];
}

/* Stores a[0], b[0], a[1], b[1], ...: twice as many numbers. */
static inline void simd_store_pairs(simd_vector a, simd_vector b, float *to)
{
    simd_stored *vectors = (simd_stored *)to;
#ifdef __AVX512F__
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    vectors[0] = _mm512_permutex2var_ps(a, low, b);
    vectors[1] = _mm512_permutex2var_ps(a, high, b);
#elif defined __AVX__
    const __m256 low = _mm256_unpacklo_ps(a, b), high = _mm256_unpackhi_ps(a, b);
    vectors[0] = _mm256_permute2f128_ps(low, high, 0x20);
    vectors[1] = _mm256_permute2f128_ps(low, high, 0x31);
#else
    vectors[0] = _mm_unpacklo_ps(a, b);
    vectors[1] = _mm_unpackhi_ps(a, b);
#endif
}

/* Computes a b + c, as fused.h does. */
static inline simd_vector simd_fused(simd_vector a, simd_vector b, simd_vector c)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#elif defined __AVX__
    return (simd_vector)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
    return (simd_vector)fused_4(a, b, c);
#endif
}

/* Returns the dot product of vectors in space. */
static inline simd_vector simd_dot(const simd_vector a[3], const simd_vector b[3])
{
    return simd_fused(a[2], b[2], simd_fused(a[1], b[1], a[0] * b[0]));
}

/* Returns the square root, rounded once as IEEE 754 says. */
static inline simd_vector simd_root(simd_vector x)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_sqrt_ps((__m512)x);
#elif defined __AVX__
    return (simd_vector)_mm256_sqrt_ps((__m256)x);
#else
    return (simd_vector)_mm_sqrt_ps((__m128)x);
#endif
}

/* Returns a number in all lanes. */
static inline simd_vector simd_same(float number)
{
    return number - (simd_vector){0};
}

static inline struct simd simd_all(float number)
{
    struct simd out;
    for (int v = 0; v < SIMD_VECTORS; v++) out.v[v] = simd_same(number);
    return out;
}

/* Returns a where the mask is set, else 0. */
static inline simd_vector simd_where(simd_mask mask, simd_vector a)
{
    return (simd_vector)(mask & (simd_mask)a);
}

/* Returns a where the mask is set, else b, whose bits are copied. */
static inline simd_vector simd_select(simd_mask mask, simd_vector a, simd_vector b)
{
    return (simd_vector)((mask & (simd_mask)a) | (~mask & (simd_mask)b));
}

/* Returns the lower of two; b where either is NaN. */
static inline simd_vector simd_min(simd_vector a, simd_vector b)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined __AVX__
    return (simd_vector)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return (simd_vector)_mm_min_ps((__m128)a, (__m128)b);
#endif
}

/* Returns the higher of two; b where either is NaN. */
static inline simd_vector simd_max(simd_vector a, simd_vector b)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_max_ps((__m512)a, (__m512)b);
#elif defined __AVX__
    return (simd_vector)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return (simd_vector)_mm_max_ps((__m128)a, (__m128)b);
#endif
}

/* Chosen lanes, in a mask register where the CPU has such, which sums take as it is. */
#ifdef __AVX512F__
typedef __mmask16 simd_chosen;
#else
typedef simd_mask simd_chosen;
#endif

/* Chooses the lanes that have one of the bits. */
static inline simd_chosen simd_with(simd_mask a, int32_t bits)
{
#ifdef __AVX512F__
    return _mm512_test_epi32_mask((__m512i)a, _mm512_set1_epi32(bits));
#else
    return (a & bits) != 0;
#endif
}

/* Chooses the lanes where a <= b. */
static inline simd_chosen simd_up_to(simd_vector a, simd_vector b)
{
#ifdef __AVX512F__
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
#else
    return a <= b;
#endif
}

/* Chooses the lanes where a < b. */
static inline simd_chosen simd_below(simd_vector a, simd_vector b)
{
#ifdef __AVX512F__
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
#else
    return a < b;
#endif
}

/* Returns whether any lane is chosen. */
static inline int simd_some(simd_chosen chosen)
{
#ifdef __AVX512F__
    return chosen != 0;
#elif defined __AVX__
    return !_mm256_testz_si256((__m256i)chosen, (__m256i)chosen);
#else
    return _mm_movemask_ps((__m128)chosen) != 0;
#endif
}

/* Returns a where chosen, else 0. */
static inline simd_vector simd_only(simd_chosen chosen, simd_vector a)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_maskz_mov_ps(chosen, (__m512)a);
#else
    return simd_where(chosen, a);
#endif
}

/* Does the same for whole numbers. */
static inline simd_mask simd_only_whole(simd_chosen chosen, simd_mask a)
{
#ifdef __AVX512F__
    return (simd_mask)_mm512_maskz_mov_epi32(chosen, (__m512i)a);
#else
    return chosen & a;
#endif
}

/* Returns sum, which is not -0, plus a where chosen. */
static inline simd_vector simd_add_to(simd_vector sum, simd_chosen chosen, simd_vector a)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_mask_add_ps((__m512)sum, chosen, (__m512)sum, (__m512)a);
#else
    return sum + simd_where(chosen, a);
#endif
}

static inline simd_vector simd_positive(simd_vector a)
{
    return (simd_vector)((simd_mask)a & INT32_MAX);
}

/* Returns a bit for each lane whose sign is set, the first lane's lowest. */
static inline uint32_t simd_signs(simd_mask mask)
{
#ifdef __AVX512F__
    return (uint32_t)_mm512_movepi32_mask((__m512i)mask);
#elif defined __AVX__
    return (uint32_t)_mm256_movemask_ps((__m256)mask);
#else
    return (uint32_t)_mm_movemask_ps((__m128)mask);
#endif
}

/* Returns whether any lane of a mask is set. */
static inline int simd_any(const struct simd_whole *mask)
{
    simd_mask all = mask->v[0];
    for (int v = 1; v < SIMD_VECTORS; v++) all |= mask->v[v];
#ifdef __AVX512F__
    return simd_some(_mm512_test_epi32_mask((__m512i)all, (__m512i)all));
#else
    return simd_some(all);
#endif
}
