#pragma once
/* Sixteen numbers side by side, in the registers of whatever instruction set the including file is
 * compiled for. Plain operators work on their vectors. A comparison gives a mask. Named ones give
 * lanes_chosen, for which AVX-512 has registers of its own. */
#include <stdint.h>

#include <immintrin.h>

#include "server/reconstruct/simd/fused.h"

#define LANES_COUNT 16
#ifdef __AVX512F__
#define LANES_VECTOR_BYTES 64
#elif defined __AVX__
#define LANES_VECTOR_BYTES 32
#else
#define LANES_VECTOR_BYTES 16
#endif
#define LANES_VECTORS    (LANES_COUNT * 4 / LANES_VECTOR_BYTES)
#define LANES_PER_VECTOR (LANES_VECTOR_BYTES / 4)

typedef float lanes_vector __attribute__((vector_size(LANES_VECTOR_BYTES)));
typedef int32_t lanes_mask __attribute__((vector_size(LANES_VECTOR_BYTES))); /* 0 or -1 */

/* The same vectors, anywhere in memory. */
typedef float lanes_stored __attribute__((vector_size(LANES_VECTOR_BYTES), aligned(4), may_alias));
typedef int32_t lanes_stored_mask
    __attribute__((vector_size(LANES_VECTOR_BYTES), aligned(4), may_alias));

struct lanes {
    lanes_vector v[LANES_VECTORS];
};

struct lanes_whole {
    lanes_mask v[LANES_VECTORS];
};

static inline lanes_vector lanes_load_vector(const float *from)
{
    return *(const lanes_stored *)from;
}

static inline lanes_mask lanes_load_mask(const int32_t *from)
{
    return *(const lanes_stored_mask *)from;
}

static inline struct lanes lanes_load(const float *from)
{
    struct lanes out;
    for (int v = 0; v < LANES_VECTORS; v++)
        out.v[v] = lanes_load_vector(from + v * LANES_PER_VECTOR);
    return out;
}

static inline struct lanes_whole lanes_load_whole(const int32_t *from)
{
    struct lanes_whole out;
    for (int v = 0; v < LANES_VECTORS; v++) out.v[v] = lanes_load_mask(from + v * LANES_PER_VECTOR);
    return out;
}

static inline void lanes_store(const struct lanes *from, float *to)
{
    lanes_stored *vectors = (lanes_stored *)to;
    for (int v = 0; v < LANES_VECTORS; v++) vectors[v] = from->v[v];
}

/* Stores a[0], b[0], a[1], b[1], ...: twice as many numbers. */
static inline void lanes_store_pairs(lanes_vector a, lanes_vector b, float *to)
{
    lanes_stored *vectors = (lanes_stored *)to;
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
static inline lanes_vector lanes_fused(lanes_vector a, lanes_vector b, lanes_vector c)
{
#ifdef __AVX512F__
    return (lanes_vector)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#elif defined __AVX__
    return (lanes_vector)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
    return (lanes_vector)fused_4(a, b, c);
#endif
}

/* Returns the dot product of vectors in space. */
static inline lanes_vector lanes_dot(const lanes_vector a[3], const lanes_vector b[3])
{
    return lanes_fused(a[2], b[2], lanes_fused(a[1], b[1], a[0] * b[0]));
}

/* Returns a number in all lanes. */
static inline lanes_vector lanes_same(float number)
{
    return number - (lanes_vector){0};
}

static inline struct lanes lanes_all(float number)
{
    struct lanes out;
    for (int v = 0; v < LANES_VECTORS; v++) out.v[v] = lanes_same(number);
    return out;
}

/* Returns a where the mask is set, else 0. */
static inline lanes_vector lanes_where(lanes_mask mask, lanes_vector a)
{
    return (lanes_vector)(mask & (lanes_mask)a);
}

/* Returns a where the mask is set, else b, whose bits are copied. */
static inline lanes_vector lanes_select(lanes_mask mask, lanes_vector a, lanes_vector b)
{
    return (lanes_vector)((mask & (lanes_mask)a) | (~mask & (lanes_mask)b));
}

/* Returns the lower of two; b where either is NaN. */
static inline lanes_vector lanes_least(lanes_vector a, lanes_vector b)
{
#ifdef __AVX512F__
    return (lanes_vector)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined __AVX__
    return (lanes_vector)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return (lanes_vector)_mm_min_ps((__m128)a, (__m128)b);
#endif
}

/* Returns the higher of two; b where either is NaN. */
static inline lanes_vector lanes_most(lanes_vector a, lanes_vector b)
{
#ifdef __AVX512F__
    return (lanes_vector)_mm512_max_ps((__m512)a, (__m512)b);
#elif defined __AVX__
    return (lanes_vector)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return (lanes_vector)_mm_max_ps((__m128)a, (__m128)b);
#endif
}

/* Chosen lanes, in a mask register where the CPU has such, which sums take as it is. */
#ifdef __AVX512F__
typedef __mmask16 lanes_chosen;
#else
typedef lanes_mask lanes_chosen;
#endif

/* Chooses the lanes that have one of the bits. */
static inline lanes_chosen lanes_with(lanes_mask a, int32_t bits)
{
#ifdef __AVX512F__
    return _mm512_test_epi32_mask((__m512i)a, _mm512_set1_epi32(bits));
#else
    return (a & bits) != 0;
#endif
}

/* Chooses the lanes where a <= b. */
static inline lanes_chosen lanes_up_to(lanes_vector a, lanes_vector b)
{
#ifdef __AVX512F__
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
#else
    return a <= b;
#endif
}

/* Chooses the lanes where a < b. */
static inline lanes_chosen lanes_below(lanes_vector a, lanes_vector b)
{
#ifdef __AVX512F__
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
#else
    return a < b;
#endif
}

/* Returns whether any lane is chosen. */
static inline int lanes_some(lanes_chosen chosen)
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
static inline lanes_vector lanes_only(lanes_chosen chosen, lanes_vector a)
{
#ifdef __AVX512F__
    return (lanes_vector)_mm512_maskz_mov_ps(chosen, (__m512)a);
#else
    return lanes_where(chosen, a);
#endif
}

/* Does the same for whole numbers. */
static inline lanes_mask lanes_only_whole(lanes_chosen chosen, lanes_mask a)
{
#ifdef __AVX512F__
    return (lanes_mask)_mm512_maskz_mov_epi32(chosen, (__m512i)a);
#else
    return chosen & a;
#endif
}

/* Returns sum, which is not -0, plus a where chosen. */
static inline lanes_vector lanes_add_to(lanes_vector sum, lanes_chosen chosen, lanes_vector a)
{
#ifdef __AVX512F__
    return (lanes_vector)_mm512_mask_add_ps((__m512)sum, chosen, (__m512)sum, (__m512)a);
#else
    return sum + lanes_where(chosen, a);
#endif
}

static inline lanes_vector lanes_positive(lanes_vector a)
{
    return (lanes_vector)((lanes_mask)a & INT32_MAX);
}

/* Returns a bit for each lane whose sign is set, the first lane's lowest. */
static inline uint32_t lanes_signs(lanes_mask mask)
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
static inline int lanes_any(const struct lanes_whole *mask)
{
    lanes_mask all = mask->v[0];
    for (int v = 1; v < LANES_VECTORS; v++) all |= mask->v[v];
#ifdef __AVX512F__
    return lanes_some(_mm512_test_epi32_mask((__m512i)all, (__m512i)all));
#else
    return lanes_some(all);
#endif
}
