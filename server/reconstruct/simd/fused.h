#pragma once
/* Computes a b + c. Where the instruction set has that operation (AVX2 and later), it is rounded
 * once and replaces two operations in most kernels. Kernels always call it by name. If the compiler
 * chose, a pixel's bits would depend on the loop that it lands in. SSE4.2 rounds a b first, so its
 * last bits differ.
 *
 * FUSED_BY_LIBRARY, which tests define, rounds once everywhere, for the reference of fused kernels.
 */
#include <immintrin.h>

static inline float fused(float a, float b, float c)
{
#if defined __FMA__ || defined FUSED_BY_LIBRARY
    return __builtin_fmaf(a, b, c);
#else
    return a * b + c;
#endif
}

/* Four and eight numbers side by side, anywhere in memory. */
typedef float fused_four __attribute__((vector_size(16), aligned(4), may_alias));
typedef float fused_eight __attribute__((vector_size(32), aligned(4), may_alias));

static inline fused_four fused_4(fused_four a, fused_four b, fused_four c)
{
#ifdef __FMA__
    return (fused_four)_mm_fmadd_ps((__m128)a, (__m128)b, (__m128)c);
#elif defined FUSED_BY_LIBRARY
    for (int i = 0; i < 4; i++) c[i] = fused(a[i], b[i], c[i]);
    return c;
#else
    return a * b + c;
#endif
}

/* Computes *c += a b. */
static inline void fused_add_8(const fused_eight *a, const fused_eight *b, fused_eight *c)
{
#ifdef __FMA__
    *c = (fused_eight)_mm256_fmadd_ps((__m256)*a, (__m256)*b, (__m256)*c);
#elif defined FUSED_BY_LIBRARY
    for (int i = 0; i < 8; i++) (*c)[i] = fused((*a)[i], (*b)[i], (*c)[i]);
#else
    *c = *a * *b + *c;
#endif
}
