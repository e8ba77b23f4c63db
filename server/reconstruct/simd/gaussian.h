#pragma once
/* Exponentials whose bits do not depend on what the C library chooses by CPU. They vectorise. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "server/reconstruct/simd/fused.h"

/* Returns exp(-x) for x >= 0; 0 from 87 on, and for infinity. The relative error is 3e-7. The
 * series is summed in halves, so that few of its terms wait for each other. */
static inline float gaussian_exp_minus(float x)
{
    const float in = x < 87.0f ? x : 87.0f;
    const float n = floorf(fused(in, -1.44269504f, 0.5f));
    /* ln 2 in two parts, the first of 15 bits: n times it is exact */
    const float rest = fused(n, 1.42860677e-6f, fused(n, 0.693145752f, in));
    const float squared = rest * rest;
    const float low = fused(squared, fused(rest, -1.0f / 6, 0.5f), 1.0f - rest);
    const float high = fused(squared, 1.0f / 720, fused(rest, -1.0f / 120, 1.0f / 24));
    const float p = fused(squared * squared, high, low);
    const uint32_t bits = (uint32_t)((int32_t)n + 127) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return x < 87.0f ? p * power : 0.0f;
}

/* Returns the normal distribution function, by a logistic of a cubic. The absolute error is 1.5e-4.
 */
static inline float gaussian_phi(float z)
{
    const float t = z * fused(0.070566f * z, z, 1.5976f);
    const float e = gaussian_exp_minus(t < 0.0f ? -t : t);
    return (t < 0.0f ? e : 1.0f) / (1.0f + e);
}
