#pragma once
/* The exponential of gaussian.h for vectors, to the last bit. A loop over the scalar function is
 * not vectorised where it is as short as a vector. */
#include "server/reconstruct/simd/gaussian.h"
#include "server/reconstruct/simd/lanes_vector.h"

static inline lanes_vector gaussian_floor(lanes_vector x)
{
#ifdef __AVX512F__
    return (lanes_vector)_mm512_floor_ps((__m512)x);
#elif defined __AVX__
    return (lanes_vector)_mm256_floor_ps((__m256)x);
#else
    return (lanes_vector)_mm_floor_ps((__m128)x);
#endif
}

/* Does gaussian_exp_minus for each lane. */
static inline lanes_vector gaussian_exp_minus_lanes(lanes_vector x)
{
    const lanes_chosen small = lanes_below(x, lanes_same(87.0f));
    const lanes_vector in = lanes_least(x, lanes_same(87.0f));
    const lanes_vector n =
        gaussian_floor(lanes_fused(in, lanes_same(-1.44269504f), lanes_same(0.5f)));
    const lanes_vector rest =
        lanes_fused(n, lanes_same(1.42860677e-6f), lanes_fused(n, lanes_same(0.693145752f), in));
    const lanes_vector squared = rest * rest;
    const lanes_vector linear = lanes_fused(rest, lanes_same(-1.0f / 6), lanes_same(0.5f));
    const lanes_vector low = lanes_fused(squared, linear, 1.0f - rest);
    const lanes_vector fourth = lanes_fused(rest, lanes_same(-1.0f / 120), lanes_same(1.0f / 24));
    const lanes_vector high = lanes_fused(squared, lanes_same(1.0f / 720), fourth);
    const lanes_vector p = lanes_fused(squared * squared, high, low);
    const lanes_mask power = (__builtin_convertvector(n, lanes_mask) + 127) << 23;
    return lanes_only(small, p * (lanes_vector)power);
}
