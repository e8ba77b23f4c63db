#pragma once
/* a b + c, rounded once where the instruction set has that operation (AVX2 and later): it takes the
 * place of two in most of what kernels do. It is always asked for by name, never left to the
 * compiler, so that a pixel's bits do not hang on which loop it lands in. SSE4.2 rounds a b first:
 * its last bits are others.
 *
 * FUSED_BY_LIBRARY, which tests define, rounds once everywhere: the reference of kernels that do.
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

/* *c += a b. */
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
