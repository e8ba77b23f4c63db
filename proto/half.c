#include "proto/half.h"

#include <cpuid.h>
#include <immintrin.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>

/* Bit patterns of single precision. */
#define SINGLE_INFINITY    0x7f800000u
#define SINGLE_HALF_MAX    0x477fe000u /* 65504 */
#define SINGLE_HALF_NORMAL 0x38800000u /* 2^-14: the smallest normal half */
#define SINGLE_HALF_TINY   0x33000000u /* 2^-25: half of the smallest half; ties to even, so to 0 */
#define EXPONENT_SHIFT     (112u << 23) /* the exponents' biases differ by 127 - 15 */

/* Below 2^-14 halves are multiples of 2^-24. */
static uint16_t subnormal_from(uint32_t magnitude)
{
    uint32_t shift = 126 - (magnitude >> 23); /* 14 to 24 */
    uint32_t mantissa = (magnitude & 0x7fffffu) | 0x800000u;
    uint32_t kept = mantissa >> shift;
    uint32_t rest = mantissa & ((1u << shift) - 1);
    uint32_t tie = 1u << (shift - 1);
    return (uint16_t)(kept + (rest > tie || (rest == tie && (kept & 1u) != 0)));
}

uint16_t half_from_float(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    uint16_t sign = (uint16_t)(bits >> 16 & 0x8000u);
    uint32_t magnitude = bits & 0x7fffffffu;
    uint32_t half;
    if (magnitude > SINGLE_INFINITY)
        half = 0x7e00u | (magnitude >> 13 & 0x3ffu); /* a quiet NaN, as the CPU makes it */
    else if (magnitude == SINGLE_INFINITY)
        half = 0x7c00u;
    else if (magnitude >= SINGLE_HALF_MAX)
        half = 0x7bffu;
    else if (magnitude >= SINGLE_HALF_NORMAL)
        half = (magnitude - EXPONENT_SHIFT + 0xfffu + (magnitude >> 13 & 1u)) >> 13;
    else if (magnitude > SINGLE_HALF_TINY)
        half = subnormal_from(magnitude);
    else
        half = 0;
    return (uint16_t)(sign | half);
}

float half_to_float(uint16_t h)
{
    uint32_t sign = (uint32_t)(h & 0x8000u) << 16;
    uint32_t exponent = h >> 10 & 31u;
    uint32_t mantissa = h & 0x3ffu;
    uint32_t bits;
    if (exponent == 31)
        bits = SINGLE_INFINITY | mantissa << 13 | (mantissa != 0 ? 0x400000u : 0);
    else if (exponent != 0)
        bits = (exponent + 112) << 23 | mantissa << 13;
    else if (mantissa == 0)
        bits = 0;
    else {
        uint32_t up = (uint32_t)__builtin_clz(mantissa) - 21; /* until bit 10 is set */
        bits = (113 - up) << 23 | (mantissa << up & 0x3ffu) << 13;
    }
    bits |= sign;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Returns whether CPU and operating system can run the F16C rows. It asks once, as cpuid is slow in
 * a virtual machine. __builtin_cpu_supports knows "f16c" only in gcc. */
static bool has_f16c(void)
{
    static atomic_int known; /* 0: not asked yet, 1: no, 2: yes */
    int answer = atomic_load_explicit(&known, memory_order_relaxed);
    if (answer == 0) {
        unsigned a, b, c = 0, d;
        bool f16c = __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_F16C) != 0;
        answer = f16c && __builtin_cpu_supports("avx") ? 2 : 1;
        atomic_store_explicit(&known, answer, memory_order_relaxed);
    }
    return answer == 2;
}

/* Both return how many elements they converted: whole groups of 8. */
__attribute__((target("avx,f16c"))) static size_t from_floats_f16c(const float *in, uint16_t *out,
                                                                   size_t count)
{
    const __m256 infinity = _mm256_set1_ps(__builtin_inff());
    const __m256 most = _mm256_set1_ps(HALF_MAX), least = _mm256_set1_ps(-HALF_MAX);
    const __m256 sign = _mm256_set1_ps(-0.0f);
    size_t i = 0;
    for (; i + 8 <= count; i += 8) {
        __m256 v = _mm256_loadu_ps(in + i);
        __m256 finite = _mm256_cmp_ps(_mm256_andnot_ps(sign, v), infinity, _CMP_LT_OQ);
        __m256 clamped = _mm256_max_ps(_mm256_min_ps(v, most), least);
        v = _mm256_blendv_ps(v, clamped, finite);
        __m128i halves = _mm256_cvtps_ph(v, _MM_FROUND_TO_NEAREST_INT);
        _mm_storeu_si128((__m128i *)(void *)(out + i), halves);
    }
    return i;
}

__attribute__((target("avx,f16c"))) static size_t to_floats_f16c(const uint16_t *in, float *out,
                                                                 size_t count)
{
    size_t i = 0;
    for (; i + 8 <= count; i += 8) {
        __m128i halves = _mm_loadu_si128((const __m128i *)(const void *)(in + i));
        _mm256_storeu_ps(out + i, _mm256_cvtph_ps(halves));
    }
    return i;
}

void half_from_floats(const float *in, uint16_t *out, size_t count)
{
    size_t i = has_f16c() ? from_floats_f16c(in, out, count) : 0;
    for (; i < count; i++) out[i] = half_from_float(in[i]);
}

void half_to_floats(const uint16_t *in, float *out, size_t count)
{
    size_t i = has_f16c() ? to_floats_f16c(in, out, count) : 0;
    for (; i < count; i++) out[i] = half_to_float(in[i]);
}
