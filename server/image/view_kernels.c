#include "server/image/view_kernels.h"

#include <stdint.h>
#include <string.h>

/* Beyond this a curve has long reached 1, and squares are still finite. */
#define LIGHT_MAX 1e9

/* log2 of the least and the largest light that AgX tells apart: 10 stops below middle grey and 6.5
 * above it. */
#define AGX_LEAST_EV (-12.47393)
#define AGX_MOST_EV  4.026069

#define MANTISSA_BITS  52
#define ROOT_HALF_BITS 0x3fe6a09e667f3bcdu /* of sqrt(1/2) */
#define TWO_52         0x1p52              /* from here on a number's last bit is worth 1 */
#define TWO_52_BITS    0x4330000000000000u
#define POWERS_BELOW   1024u /* more than there are powers of two below 1 */

static const double rec2020_of_709[3][3] = {
    {0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0113}, {0.0164, 0.0880, 0.8956}};
static const double rec709_of_2020[3][3] = {
    {1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}};
static const double agx_inset[3][3] = {{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                                       {0.137318972929847, 0.761241990602591, 0.101439036467562},
                                       {0.11189821299995, 0.0767994186031903, 0.811302368396859}};
static const double agx_outset[3][3] = {
    {1.1271005818144368, -0.11060664309660323, -0.016493938717834573},
    {-0.1413297634984383, 1.157823702216272, -0.016493938717834257},
    {-0.14132976349843826, -0.11060664309660294, 1.2519364065950405}};

static uint64_t to_bits(double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static double from_bits(uint64_t bits)
{
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static double clip(double v, double most)
{
    return v > 0.0 ? (v < most ? v : most) : 0.0; /* NaN, too */
}

/* Returns log2 of a normal number above 0, with an error of 1e-13. The number is m times a power of
 * two, m next to 1; the series is that of the area tangent in (m - 1) / (m + 1). The C library's
 * function does not vectorise. */
static double log2_of(double v)
{
    const uint64_t least = ROOT_HALF_BITS, mantissa = ((uint64_t)1 << MANTISSA_BITS) - 1;
    const uint64_t bits = to_bits(v) - least + ((uint64_t)POWERS_BELOW << MANTISSA_BITS);
    const double power = from_bits(bits >> MANTISSA_BITS | TWO_52_BITS) - (TWO_52 + POWERS_BELOW);
    const double m = from_bits((bits & mantissa) + least);
    const double s = (m - 1) / (m + 1), q = s * s;
    double sum = 1.0 / 15;
    sum = sum * q + 1.0 / 13;
    sum = sum * q + 1.0 / 11;
    sum = sum * q + 1.0 / 9;
    sum = sum * q + 1.0 / 7;
    sum = sum * q + 1.0 / 5;
    sum = sum * q + 1.0 / 3;
    return power + (sum * q + 1) * s * 2.8853900817779268; /* 2 / ln 2 */
}

/* Returns 2^x of -1000 .. 1000, with a relative error of 1e-12, by the exponential's series around
 * the whole number next to x. */
static double exp2_of(double x)
{
    const double rounding = 1.5 * TWO_52, shifted = x + rounding;
    const double t = (x - (shifted - rounding)) * 0.6931471805599453; /* ln 2 */
    double sum = 1.0 / 3628800;
    sum = sum * t + 1.0 / 362880;
    sum = sum * t + 1.0 / 40320;
    sum = sum * t + 1.0 / 5040;
    sum = sum * t + 1.0 / 720;
    sum = sum * t + 1.0 / 120;
    sum = sum * t + 1.0 / 24;
    sum = sum * t + 1.0 / 6;
    sum = sum * t + 0.5;
    sum = sum * t + 1;
    sum = sum * t + 1;
    return from_bits(to_bits(sum) + (to_bits(shifted) << MANTISSA_BITS));
}

static double agx_sigmoid(double v)
{
    const double range = AGX_MOST_EV - AGX_LEAST_EV;
    const double x = clip((log2_of(v > 1e-10 ? v : 1e-10) - AGX_LEAST_EV) / range, 1.0);
    return (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x -
           0.00232;
}

static double agx_power(double v)
{
    const double power = exp2_of(2.2 * log2_of(v > 1e-30 ? v : 1e-30));
    return v > 0.0 ? power : 0.0;
}

static void turn(const double matrix[3][3], struct view_pixels *p)
{
    for (int i = 0; i < VIEW_PIXELS; i++) {
        const double in[3] = {p->channel[0][i], p->channel[1][i], p->channel[2][i]};
        for (int r = 0; r < 3; r++)
            p->channel[r][i] = matrix[r][0] * in[0] + matrix[r][1] * in[1] + matrix[r][2] * in[2];
    }
}

static double filmic(double v)
{
    const double x = 0.6 * v;
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

static double clip_shown(double v)
{
    return clip(v, 1);
}

/* Replaces each number of the pixels; the loop is the function's own once that is in it. */
static inline __attribute__((always_inline)) void replace(struct view_pixels *p,
                                                          double (*by)(double v))
{
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < VIEW_PIXELS; i++) p->channel[c][i] = by(p->channel[c][i]);
}

static void agx(struct view_pixels *p)
{
    turn(rec2020_of_709, p);
    turn(agx_inset, p);
    replace(p, agx_sigmoid);
    turn(agx_outset, p);
    replace(p, agx_power);
    turn(rec709_of_2020, p);
}

static void show(enum view_curve curve, double scale, struct view_pixels *p)
{
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < VIEW_PIXELS; i++)
            p->channel[c][i] = clip(p->channel[c][i] * scale, LIGHT_MAX);
    if (curve == VIEW_FILMIC) replace(p, filmic);
    if (curve == VIEW_AGX) agx(p);
    replace(p, clip_shown);
}

const struct view_kernels KERNELS(view_kernels) = {.show = show};
