#include "proto/pattern.h"

#include <math.h>

/* R2 sequence (Roberts 2018): 1/g and 1/g^2 of the plastic number g, as 64-bit fractions. Products
 * with pixel coordinates wrap, which is just what a fractional part does, so that jitter is exact
 * at any pixel and on any platform. */
#define R2_A UINT64_C(0xc13fa9a902a6328f)
#define R2_B UINT64_C(0x91e10da5c79e7b1d)

/* The golden ratio's fraction: spaces the radii of a pixel's anti-aliasing rays. */
#define GOLDEN_FRACTION UINT64_C(0x9e3779b97f4a7c15)

#define BELOW_ONE 0x1.fffffep-1f

/* Keeps stratum + jitter below the next stratum after rounding, for 256 strata an axis. */
#define JITTER_MAX (65535.0f / 65536.0f)

/* Purposes that must not share a hash. */
enum pattern_purpose { PURPOSE_ORIGIN_0 = 1, PURPOSE_ORIGIN_1, PURPOSE_OFFSET, PURPOSE_ORDER };

/* A bijection of 64 bits in which every input bit moves every output bit (two rounds of
 * multiply and xor-shift; constants of Stafford's variant 13, also used by SplitMix64). */
static uint64_t mix(uint64_t v)
{
    v ^= v >> 30;
    v *= UINT64_C(0xbf58476d1ce4e5b9);
    v ^= v >> 27;
    v *= UINT64_C(0x94d049bb133111eb);
    v ^= v >> 31;
    return v;
}

static uint64_t frame_key(const struct pattern *p, uint32_t dimension, enum pattern_purpose purpose)
{
    uint64_t h = mix(p->seed + UINT64_C(0x9e3779b97f4a7c15));
    return mix(h ^ ((uint64_t)p->frame << 32 | dimension << 3 | (uint32_t)purpose));
}

static uint64_t pixel_key(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension,
                          enum pattern_purpose purpose)
{
    return mix(frame_key(p, dimension, purpose) ^ ((uint64_t)(uint32_t)y << 32 | (uint32_t)x));
}

static float unit_float(uint64_t fraction)
{
    return (float)(fraction >> 40) * 0x1p-24f;
}

/* Dimensions that a filter or an estimator combines must not be tied to each other by a linear
 * relation, which any two translates of one lattice are. The lattice mirrored in x has no relation
 * with the straight one: over the four phases only the zero integer combination is constant. The
 * remaining dimensions draw signs, which at least breaks the plain translates. */
static void lattice_phase(uint32_t dimension, int32_t x, int32_t y, uint64_t phase[2])
{
    const int mirrored = dimension == PATTERN_PIXEL || dimension == PATTERN_LENS;
    const uint64_t px = mirrored ? 0 - (uint64_t)(int64_t)x : (uint64_t)(int64_t)x;
    const uint64_t py = (uint64_t)(int64_t)y;
    const uint64_t signs = dimension == PATTERN_LIGHT ? 0 : mix(dimension + 1);
    phase[0] = px * R2_A + py * R2_B;
    phase[1] = px * R2_B - py * R2_A;
    if (signs & 1) phase[0] = 0 - phase[0];
    if (signs & 2) phase[1] = 0 - phase[1];
}

void pattern_jitter(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension, float out[2])
{
    uint64_t phase[2];
    lattice_phase(dimension, x, y, phase);
    out[0] = unit_float(phase[0] + frame_key(p, dimension, PURPOSE_ORIGIN_0));
    out[1] = unit_float(phase[1] + frame_key(p, dimension, PURPOSE_ORIGIN_1));
}

void pattern_stratum(const float jitter[2], uint32_t l, uint32_t i, float out[2])
{
    const float side = (float)l;
    out[0] = ((float)(i % l) + fminf(jitter[0], JITTER_MAX)) / side;
    out[1] = ((float)(i / l) + fminf(jitter[1], JITTER_MAX)) / side;
}

/* A keyed bijection of 0..mask, mask = 2^k - 1: multiplication by odd numbers, xor with a right
 * shift and addition are each invertible on k bits. */
static uint32_t scramble(uint32_t v, uint32_t mask, uint32_t half_bits, uint64_t key)
{
    const uint32_t odd_0 = (uint32_t)key | 1, odd_1 = (uint32_t)(key >> 17) | 1;
    v = (v + (uint32_t)(key >> 32)) & mask;
    v = (v * odd_0) & mask;
    v ^= v >> half_bits;
    v = (v * UINT32_C(0x2c1b3c6d)) & mask;
    v ^= v >> half_bits;
    v = (v + (uint32_t)(key >> 8)) & mask;
    v = (v * odd_1) & mask;
    v ^= v >> half_bits;
    v = (v * UINT32_C(0x297a2d39)) & mask;
    return v ^ v >> half_bits;
}

/* Element i of a hashed permutation of 0..count-1: values that the bijection of the next power of
 * two puts outside are sent through it again, which ends because its cycles do. */
static uint32_t permute(uint32_t i, uint32_t count, uint64_t key)
{
    if (count <= 1) return 0;
    const uint32_t bits = 32 - (uint32_t)__builtin_clz(count - 1);
    const uint32_t mask = (uint32_t)((UINT64_C(1) << bits) - 1);
    const uint32_t half_bits = (bits + 1) / 2;
    do {
        i = scramble(i, mask, half_bits, key);
    } while (i >= count);
    return i;
}

void pattern_shuffled(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension, uint32_t l,
                      uint32_t i, float out[2])
{
    const uint64_t offset = pixel_key(p, x, y, dimension, PURPOSE_OFFSET);
    const uint64_t order = pixel_key(p, x, y, dimension, PURPOSE_ORDER);
    const float jitter[2] = {unit_float(offset), unit_float(offset << 32)};
    pattern_stratum(jitter, l, permute(i, l * l, order), out);
}

/* The point at fraction s along the edge of the square [-1,1]^2. */
static void square_edge(float s, float edge[2])
{
    const float along = 4.0f * s;
    const int side = (int)along;
    const float t = 2.0f * (along - (float)side) - 1.0f;
    const float points[4][2] = {{1.0f, t}, {-t, 1.0f}, {-1.0f, -t}, {t, -1.0f}};
    edge[0] = points[side & 3][0];
    edge[1] = points[side & 3][1];
}

/* All edges are equally far from the centre, so area grows evenly with the way along them, and with
 * the square of the distance: rays spaced evenly around the pixel, each still uniform over it. */
void pattern_pixel(const struct pattern *p, int32_t x, int32_t y, uint32_t k, uint32_t count,
                   float out[2])
{
    uint64_t phase[2];
    lattice_phase(PATTERN_PIXEL, x, y, phase);
    phase[0] += frame_key(p, PATTERN_PIXEL, PURPOSE_ORIGIN_0);
    phase[1] += frame_key(p, PATTERN_PIXEL, PURPOSE_ORIGIN_1);
    const uint64_t step = count > 1 ? UINT64_MAX / count : 0;
    float edge[2];
    square_edge(unit_float(phase[0] + k * step), edge);
    const float radius = sqrtf(unit_float(phase[1] + k * GOLDEN_FRACTION));
    for (int axis = 0; axis < 2; axis++)
        out[axis] = fminf(0.5f + 0.5f * radius * edge[axis], BELOW_ONE);
}
