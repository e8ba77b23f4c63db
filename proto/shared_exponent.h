#pragma once
/* Packs three positive numbers into 32 bits: three mantissas below one exponent, the largest
 * number's. Rounding to nearest errs by at most half a step of the largest mantissa, which is 1/256
 * of it with 8 bits and 1/512 with 9. Stochastic rounding errs by less than a step, and not at all
 * in the mean. */
#include <stdint.h>
#include <string.h>

/* Numbers up to 1, and some beyond: 9 bits each. Least step 2^-24, most 65408. */
#define SHARED_EXPONENT_9 9
/* Numbers of any size: 8 bits each. Least step 2^-126, most 1.7e38. */
#define SHARED_EXPONENT_8 8

static inline float shared_exponent_power(int32_t e)
{
    const uint32_t bits = (uint32_t)(e + 127) << 23; /* -126 <= e <= 127 */
    float power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* Returns the exponent of the power of two that mantissas of exponent 0 count. */
static inline int32_t shared_exponent_min(int mantissa_bits)
{
    return mantissa_bits == SHARED_EXPONENT_9 ? -24 : -126;
}

static inline uint32_t shared_exponent_max(int mantissa_bits)
{
    return mantissa_bits == SHARED_EXPONENT_9 ? 31 : 245;
}

/* Packs r, g, b as mantissas from the lowest bits on, and the exponent above them. `up`, in [0, 1),
 * is added to each before it is cut. Negative numbers and NaN become 0, too large ones the
 * largest. */
static inline uint32_t shared_exponent_pack_up(const float rgb[3], int mantissa_bits,
                                               const float up[3], float most_up)
{
    const int32_t least = shared_exponent_min(mantissa_bits);
    const uint32_t most = shared_exponent_max(mantissa_bits);
    const uint32_t full = (1u << mantissa_bits) - 1;
    float largest = 0.0f;
    uint32_t bits, packed = 0;
    for (int c = 0; c < 3; c++) largest = rgb[c] > largest ? rgb[c] : largest;
    memcpy(&bits, &largest, sizeof bits);
    /* largest < 2^above */
    const int32_t above = (int32_t)(bits >> 23) - 126, step = above - mantissa_bits;
    uint32_t exponent = step > least ? (uint32_t)(step - least) : 0;
    exponent = exponent < most ? exponent : most;
    float scale = shared_exponent_power(-(least + (int32_t)exponent));
    if (largest * scale + most_up >= (float)(full + 1) && exponent < most) {
        exponent++;
        scale *= 0.5f;
    }
    for (int c = 2; c >= 0; c--) {
        const float v = rgb[c] > 0.0f ? rgb[c] * scale + up[c] : 0.0f;
        packed = packed << mantissa_bits | (v < (float)full ? (uint32_t)v : full);
    }
    return packed | exponent << 3 * mantissa_bits;
}

/* Rounds to nearest. */
static inline uint32_t shared_exponent_pack(const float rgb[3], int mantissa_bits)
{
    return shared_exponent_pack_up(rgb, mantissa_bits, (const float[]){0.5f, 0.5f, 0.5f}, 0.5f);
}

/* Rounds up or down by eight random bits for each number, the lowest 24, so that the mean over all
 * of them is the number, to 1/512 of a step. Exact numbers stay. */
static inline uint32_t shared_exponent_pack_random(const float rgb[3], int mantissa_bits,
                                                   uint32_t random)
{
    float up[3];
    for (int c = 0; c < 3; c++) up[c] = (float)(2 * (random >> 8 * c & 255u) + 1) * (1.0f / 512.0f);
    return shared_exponent_pack_up(rgb, mantissa_bits, up, 511.0f / 512.0f);
}

static inline void shared_exponent_unpack(uint32_t packed, int mantissa_bits, float rgb[3])
{
    const uint32_t full = (1u << mantissa_bits) - 1;
    const int32_t exponent = (int32_t)(packed >> 3 * mantissa_bits);
    const float scale = shared_exponent_power(shared_exponent_min(mantissa_bits) + exponent);
    for (int c = 0; c < 3; c++) rgb[c] = (float)(packed >> c * mantissa_bits & full) * scale;
}
