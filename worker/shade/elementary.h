#pragma once
/* Elementary functions whose results are the same bits on every CPU: the C library picks variants
 * of its own by CPU. They have few branches, so that loops over lanes become vector code. Of the C
 * library they use only sqrtf, floorf, floor and fabsf, which are exact.
 *
 * The largest errors against the C library's double functions, measured by
 * tests/unit/worker/shade/test_elementary.c, stand with each function. Polynomials are Taylor
 * series or, where said, fits of least largest error that were made for this file. Subnormal
 * results are 0: tracing threads flush them. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define ELEMENTARY_PI      3.14159265358979324f
#define ELEMENTARY_INV_PI  0.318309886183790672f
#define ELEMENTARY_HALF_PI 1.57079632679489662f
#define ELEMENTARY_SQRT_PI 1.77245385090551603f
#define ELEMENTARY_MAX     3.40282347e38f /* where exp ends */
#define ELEMENTARY_TINY    1.17549435e-38f

static inline uint32_t elementary_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline float elementary_of_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Returns |x| with the sign of s, also of -0. */
static inline float elementary_copysign(float x, float s)
{
    return elementary_of_bits((elementary_bits(x) & 0x7fffffffu) |
                              (elementary_bits(s) & 0x80000000u));
}

/* Return sine and cosine on [-pi/4, pi/4] by Taylor series, whose own error is below 4e-8. */
static inline float elementary_small_sin(float x)
{
    const float s = x * x;
    return x * (1.0f + s * (-1.0f / 6 + s * (1.0f / 120 + s * (-1.0f / 5040 + s / 362880))));
}

static inline float elementary_small_cos(float x)
{
    const float s = x * x;
    return 1.0f + s * (-0.5f + s * (1.0f / 24 + s * (-1.0f / 720 + s / 40320)));
}

/* Splits x into quarter * pi/2 + rest and returns the rest; the quarter is modulo 4. It uses pi/2
 * in double, in two parts of which the first has 26 bits, which is exact to |x| = 2^27. Beyond,
 * where neighbouring floats are turns apart, the rest is only kept in its range. */
static inline float elementary_quarter(float x, int *quarter)
{
    const double turns = 0.636619772367581343 * (double)x;
    const double q = floor(turns + 0.5);
    double rest = ((double)x - q * 0x1.921fb50000000p+0) - q * 0x1.110b4611a6263p-26;
    rest = rest < 0.7853982 ? rest : 0.7853982;
    rest = rest > -0.7853982 ? rest : -0.7853982;
    *quarter = (int)(q - 4.0 * floor(q * 0.25));
    return (float)rest;
}

/* Returns the sine of any finite x. Relative error 1.5e-7 to |x| = 1e8. */
static inline float elementary_sin(float x)
{
    int quarter;
    const float rest = elementary_quarter(x, &quarter);
    const float s = elementary_small_sin(rest), c = elementary_small_cos(rest);
    const float value = quarter & 1 ? c : s;
    return quarter & 2 ? -value : value;
}

static inline float elementary_cos(float x)
{
    int quarter;
    const float rest = elementary_quarter(x, &quarter);
    const float s = elementary_small_sin(rest), c = elementary_small_cos(rest);
    const float value = quarter & 1 ? s : c;
    return (quarter + 1) & 2 ? -value : value;
}

/* Computes sine and cosine of 2 pi u for u in [0, 1], exact at quarter turns. Relative error
 * 1.7e-7. */
static inline void elementary_sincos_turn(float u, float *sine, float *cosine)
{
    const float t = 4.0f * u, q = floorf(t + 0.5f);
    const float rest = (t - q) * ELEMENTARY_HALF_PI; /* t - q is exact */
    const int quarter = (int)q;
    const float s = elementary_small_sin(rest), c = elementary_small_cos(rest);
    const float a = quarter & 1 ? c : s, b = quarter & 1 ? s : c;
    *sine = quarter & 2 ? -a : a;
    *cosine = (quarter + 1) & 2 ? -b : b;
}

/* Returns 2^(n + r) for r in [-1/2, 1/2] and whole n in [-126, 127], by a fit. */
static inline float elementary_exp2_split(float n, float r)
{
    const float p =
        1.0f + r * (0.693147206f +
                    r * (0.240226469f +
                         r * (0.0555032878f +
                              r * (0.00961848897f + r * (0.00133999312f + r * 0.000153458074f)))));
    return p * elementary_of_bits((uint32_t)((int32_t)n + 127) << 23);
}

/* Returns e^x for any x: 0 below -87.33, ELEMENTARY_MAX from 88.37 (not infinity, so that products
 * with 0 stay 0). Relative error 1.1e-7. */
static inline float elementary_exp(float x)
{
    const float in = x < -87.33f ? -87.33f : x > 88.37f ? 88.37f : x;
    const float n = floorf(in * 1.44269504f + 0.5f);
    /* ln 2 in two parts, the first of 15 bits: n times it is exact */
    const float rest = (in - n * 0.693145752f) - n * 1.42860677e-6f;
    const float value = elementary_exp2_split(n, rest * 1.44269504f);
    return x < -87.33f ? 0.0f : x > 88.37f ? ELEMENTARY_MAX : value;
}

/* Returns e^x - 1 for any x in [-87, 88], with its digits kept near 0. Relative error 3.2e-7. */
static inline float elementary_expm1(float x)
{
    const float small =
        x * (1.0f +
             x * (0.5f + x * (1.0f / 6 + x * (1.0f / 24 + x * (1.0f / 120 + x * (1.0f / 720))))));
    return fabsf(x) < 0.3f ? small : elementary_exp(x) - 1.0f;
}

/* Splits x > 0 into m 2^e with m in [1/sqrt 2, sqrt 2). Subnormal x counts as the least normal. */
static inline float elementary_frexp(float x, float *e)
{
    const uint32_t bits = elementary_bits(x > ELEMENTARY_TINY ? x : ELEMENTARY_TINY);
    const uint32_t above = bits - 0x3f3504f3u; /* 1/sqrt 2 */
    *e = (float)((int32_t)above >> 23);
    return elementary_of_bits((above & 0x007fffffu) + 0x3f3504f3u);
}

/* Returns the natural logarithm of finite x > 0. Smaller x count as the least normal float (-87.3).
 * Relative error 1.7e-7. */
static inline float elementary_log(float x)
{
    float e;
    const float m = elementary_frexp(x, &e);
    const float f = (m - 1.0f) / (m + 1.0f), s = f * f;
    const float twice = f + f;
    const float log_m =
        twice + twice * s * (1.0f / 3 + s * (1.0f / 5 + s * (1.0f / 7 + s * (1.0f / 9))));
    return e * 0.693145752f + (e * 1.42860677e-6f + log_m);
}

/* Returns log(1 + x) for x > -1, with its digits kept near 0. Relative error 2e-7. */
static inline float elementary_log1p(float x)
{
    const float f = x / (2.0f + x), s = f * f;
    const float small =
        f * (2.0f + s * (2.0f / 3 + s * (2.0f / 5 + s * (2.0f / 7 + s * (2.0f / 9)))));
    return fabsf(x) < 0.29f ? small : elementary_log(1.0f + x);
}

/* Returns the angle of (x, y), in [-pi, pi], as the C library does, signed zeros included.
 * Arguments are finite. Relative error 2e-7. */
static inline float elementary_atan2(float y, float x)
{
    const float ax = fabsf(x), ay = fabsf(y);
    const float most = ax > ay ? ax : ay, least = ax > ay ? ay : ax;
    /* beyond tan(pi/8) take the angle from pi/4: tan(a - pi/4) = (t - 1) / (t + 1) */
    const int wide = least > 0.414213562f * most;
    /* halved, so that the sum stays finite */
    const float over = wide ? 0.5f * least - 0.5f * most : least;
    const float under = wide ? 0.5f * least + 0.5f * most : most;
    const float z = over / (under > 0.0f ? under : 1.0f), s = z * z;
    const float small =
        z * (0.999999982f +
             s * (-0.333328079f + s * (0.199747241f + s * (-0.138544561f + s * 0.0799363948f))));
    const float octant = wide ? 0.785398163f + small : small;
    const float quadrant = ay > ax ? ELEMENTARY_HALF_PI - octant : octant;
    const float half = elementary_bits(x) >> 31 ? ELEMENTARY_PI - quadrant : quadrant;
    return elementary_copysign(half, y);
}

/* Returns exp(x^2) erfc(x) for x in [0, 4], beyond which erf is 1 as a float, by a fit in 1 / (1 +
 * x/2). Relative error 3.5e-7. */
static inline float elementary_erfcx(float x)
{
    const float t = 1.0f / (1.0f + 0.5f * x);
    return t * (0.281912481f +
                t * (0.285500893f +
                     t * (0.218669479f +
                          t * (0.311503524f +
                               t * (-0.330399985f +
                                    t * (0.828930677f +
                                         t * (-1.13607701f +
                                              t * (0.763576351f +
                                                   t * (-0.260329697f + t * 0.0367132889f)))))))));
}

/* Returns erf of any x. Relative error 1.8e-7. */
static inline float elementary_erf(float x)
{
    const float a = fabsf(x), s = a * a, end = a < 4.0f ? a : 4.0f;
    const float small =
        a * (1.12837917f +
             s * (-0.376126258f +
                  s * (0.112835851f +
                       s * (-0.0268538119f +
                            s * (0.00518832756f + s * (-0.00080101925f + s * 7.85385764e-05f))))));
    const float large = 1.0f - elementary_exp(-end * end) * elementary_erfcx(end);
    return elementary_copysign(a < 1.0f ? small : large, x);
}

/* Returns the inverse of erf on (-1, 1); arguments beyond +-(1 - 2^-24) count as these (+-3.77). It
 * has two fits, in w = -log(1 - x^2) and its root. Relative error 4.6e-7. */
static inline float elementary_erfinv(float x)
{
    const float a = fabsf(x), in = a < 0x1.fffffep-1f ? a : 0x1.fffffep-1f;
    const float w = -elementary_log((1.0f - in) * (1.0f + in));
    const float v = w - 2.5f, r = sqrtf(w > 0.0f ? w : 0.0f) - 3.0f;
    const float central =
        1.50140942f +
        v * (0.246640726f + v * (-0.00417770774f +
                                 v * (-0.00125370752f +
                                      v * (0.000218602194f +
                                           v * (-4.39678125e-06f +
                                                v * (-3.52885955e-06f +
                                                     v * (3.4372706e-07f + v * 2.853479e-08f)))))));
    const float tail =
        2.83297745f +
        r * (1.00168034f +
             r * (0.00942193847f +
                  r * (-0.00770257417f +
                       r * (0.0058419884f +
                            r * (-0.00342592321f + r * (0.00110787322f - r * 0.000117508526f))))));
    return elementary_copysign(in * (w < 5.0f ? central : tail), x);
}
