#pragma once
/* gaussian.h's exponential of numbers side by side, to the last bit: loops over it are taken apart
 * where they are as short as a vector. */
#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/lanes_vector.h"

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

/* gaussian_exp_minus. */
static inline lanes_vector gaussian_exp_minus_lanes(lanes_vector x)
{
    const lanes_mask small = x < 87.0f;
    const lanes_vector in = lanes_select(small, x, lanes_all(87.0f).v[0]);
    const lanes_vector n = gaussian_floor(in * -1.44269504f + 0.5f);
    const lanes_vector rest = (-in - n * 0.693145752f) - n * 1.42860677e-6f;
    const lanes_vector squared = rest * rest;
    const lanes_vector low = (1.0f + rest) + squared * (0.5f + rest * (1.0f / 6));
    const lanes_vector high = (1.0f / 24 + rest * (1.0f / 120)) + squared * (1.0f / 720);
    const lanes_vector p = low + squared * squared * high;
    const lanes_mask power = (__builtin_convertvector(n, lanes_mask) + 127) << 23;
    return lanes_where(small, p * (lanes_vector)power);
}
