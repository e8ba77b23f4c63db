#pragma once
/* The exponential of gaussian.h for vectors, to the last bit. A loop over the scalar function is
 * not vectorised where it is as short as a vector. */
#include "server/reconstruct/simd/gaussian.h"
#include "server/reconstruct/simd/vector.h"

static inline simd_vector gaussian_floor(simd_vector x)
{
#ifdef __AVX512F__
    return (simd_vector)_mm512_floor_ps((__m512)x);
#elif defined __AVX__
    return (simd_vector)_mm256_floor_ps((__m256)x);
#else
    return (simd_vector)_mm_floor_ps((__m128)x);
#endif
}

/* Does gaussian_exp_minus for each lane. */
static inline simd_vector gaussian_exp_minus_lanes(simd_vector x)
{
    const simd_chosen small = simd_below(x, simd_same(87.0f));
    const simd_vector in = simd_min(x, simd_same(87.0f));
    const simd_vector n = gaussian_floor(simd_fused(in, simd_same(-1.44269504f), simd_same(0.5f)));
    const simd_vector rest =
        simd_fused(n, simd_same(1.42860677e-6f), simd_fused(n, simd_same(0.693145752f), in));
    const simd_vector squared = rest * rest;
    const simd_vector linear = simd_fused(rest, simd_same(-1.0f / 6), simd_same(0.5f));
    const simd_vector low = simd_fused(squared, linear, 1.0f - rest);
    const simd_vector fourth = simd_fused(rest, simd_same(-1.0f / 120), simd_same(1.0f / 24));
    const simd_vector high = simd_fused(squared, simd_same(1.0f / 720), fourth);
    const simd_vector p = simd_fused(squared * squared, high, low);
    const simd_mask power = (__builtin_convertvector(n, simd_mask) + 127) << 23;
    return simd_only(small, p * (simd_vector)power);
}
