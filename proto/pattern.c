#include "proto/pattern.h"

#include <stdbool.h>

/* Lattices over the pixel grid, phase = M (x, y) in 64-bit fractions. Products with pixel
 * coordinates wrap, which is just what a fractional part does, so that jitter is exact at any pixel
 * and on any platform.
 *
 * The first is the R2 sequence (Roberts 2018): a = 1/g, b = 1/g^2 of the plastic number g. The
 * second has c = 1/h, d = 1/h^2 of h = 1.46557..., the root of x^3 = x^2 + 1: of the cubic numbers
 * that were tried it makes the most even lattice both by itself and in four dimensions together
 * with the first (8 x 8 bins of any two coordinates over 128 x 128 pixels: chi-square at most 3, 63
 * by chance). */
#define R2_A UINT64_C(0xc13fa9a902a6328f)
#define R2_B UINT64_C(0x91e10da5c79e7b1d)
#define H_C  UINT64_C(0xaead08f297c4cbca)
#define H_D  UINT64_C(0x772fad1ede80b462)
static const uint64_t lattices[2][2][2] = {
    {{R2_A, R2_B}, {R2_B, 0 - R2_A}},
    {{H_C, 0 - H_D}, {H_D, H_C}},
};

#define SCRAMBLE_ROUNDS 8

/* Purposes that must not share a hash. */
enum pattern_purpose { PURPOSE_ORIGIN_0 = 1, PURPOSE_ORIGIN_1, PURPOSE_DECK, PURPOSE_NET };

/* Mixes by a bijection of 64 bits in which every input bit affects every output bit: two rounds of
 * multiply and xor-shift, with the constants of Stafford's variant 13, also used by SplitMix64. */
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
    uint64_t h = mix(p->seed + PATTERN_GOLDEN_FRACTION);
    return mix(h ^ ((uint64_t)p->frame << 32 | dimension << 3 | (uint32_t)purpose));
}

static uint64_t pixel_key(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension)
{
    const uint64_t pixel = (uint64_t)(uint32_t)y << 32 | (uint32_t)x;
    return mix(frame_key(p, dimension, PURPOSE_DECK) ^ pixel);
}

/* Two dimensions that meet in one integral must not be tied by a linear relation, which translates
 * of one lattice are: those that a filter or an estimator combines with light or direction use the
 * second lattice or pattern_shuffled. The others are only summed; they draw signs, so that what
 * error the lattice leaves is not the same in each. */
static void lattice_init(const struct pattern *p, uint32_t dimension, struct pattern_lattice *out)
{
    const bool second = dimension == PATTERN_PIXEL || dimension == PATTERN_LENS;
    const uint64_t signs = dimension == PATTERN_LIGHT ? 0 : mix(dimension + 1);
    for (int axis = 0; axis < 2; axis++) {
        const uint64_t *m = lattices[second][axis];
        const bool negative = signs >> axis & 1;
        out->by[axis][0] = negative ? 0 - m[0] : m[0];
        out->by[axis][1] = negative ? 0 - m[1] : m[1];
    }
    out->origin[0] = frame_key(p, dimension, PURPOSE_ORIGIN_0);
    out->origin[1] = frame_key(p, dimension, PURPOSE_ORIGIN_1);
}

bool pattern_lattice_init(const struct pattern *p, uint32_t dimension, struct pattern_lattice *out)
{
    if (dimension >= PATTERN_LIGHT_NET) return false;
    lattice_init(p, dimension, out);
    return true;
}

static uint32_t reverse_bits(uint32_t v)
{
    v = __builtin_bswap32(v);
    v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
    v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
    return (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
}

/* Owen scrambling: each bit is flipped by a hash of the bits above it. On reversed bits that is any
 * function whose carries run upwards only (Laine and Karras 2011; constants of Vegdahl 2021). */
static uint32_t owen_scramble(uint32_t v, uint32_t key)
{
    v = reverse_bits(v);
    v ^= v * 0x3d20adeau;
    v += key;
    v *= (key >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return reverse_bits(v);
}

/* Bits of v apart, zeros between them. */
static uint32_t spread_bits(uint32_t v)
{
    v &= 0xffffu;
    v = (v | v << 8) & 0x00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0fu;
    v = (v | v << 2) & 0x33333333u;
    return (v | v << 1) & 0x55555555u;
}

/* The second coordinate of Sobol's points; the first is reverse_bits. */
static uint32_t sobol_second(uint32_t i)
{
    uint32_t v = 1u << 31, sum = 0;
    for (; i > 0; i >>= 1, v ^= v >> 1) sum ^= i & 1 ? v : 0;
    return sum;
}

/* Every aligned square of 2^k x 2^k pixels has a (0, 2)-net, in an order that differs from square
 * to square. */
static void net_jitters(const struct pattern *p, const int32_t *x, const int32_t *y, uint32_t count,
                        uint32_t dimension, float *out0, float *out1)
{
    const uint64_t key = frame_key(p, dimension, PURPOSE_NET), other = mix(key);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t morton = spread_bits((uint32_t)x[i]) | spread_bits((uint32_t)y[i]) << 1;
        const uint32_t index = owen_scramble(morton, (uint32_t)key);
        const uint32_t a = owen_scramble(reverse_bits(index), (uint32_t)(key >> 32));
        const uint32_t b = owen_scramble(sobol_second(index), (uint32_t)other);
        out0[i] = (float)(a >> 8) * 0x1p-24f;
        out1[i] = (float)(b >> 8) * 0x1p-24f;
    }
}

void pattern_jitters(const struct pattern *p, const int32_t *x, const int32_t *y, uint32_t count,
                     uint32_t dimension, float *out0, float *out1)
{
    struct pattern_lattice lattice;
    if (!pattern_lattice_init(p, dimension, &lattice)) {
        net_jitters(p, x, y, count, dimension, out0, out1);
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        out0[i] = pattern_lattice_jitter(&lattice, x[i], y[i], 0);
        out1[i] = pattern_lattice_jitter(&lattice, x[i], y[i], 1);
    }
}

void pattern_jitter(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension, float out[2])
{
    pattern_jitters(p, &x, &y, 1, dimension, &out[0], &out[1]);
}

void pattern_stratum(const float jitter[2], uint32_t l, uint32_t i, float out[2])
{
    out[0] = pattern_axis(jitter[0], l, i % l);
    out[1] = pattern_axis(jitter[1], l, i / l);
}

/* Scrambles by a keyed bijection of 0..mask, mask = 2^k - 1. Addition, multiplication by odd
 * numbers and xor with a right shift are each invertible on k bits. Few bits mix slowly, hence the
 * rounds. */
static uint32_t scramble(uint32_t v, uint32_t mask, uint32_t half_bits, uint64_t key)
{
    for (int round = 0; round < SCRAMBLE_ROUNDS; round++) {
        v = (v + (uint32_t)(key >> 16)) & mask;
        v = (v * ((uint32_t)(key >> 40) | 1)) & mask;
        v ^= v >> half_bits;
        key = key << 23 | key >> 41;
    }
    return v;
}

/* Returns element i of a hashed permutation of 0..count-1, count > 1. Values that the bijection of
 * the next power of two puts outside are sent through it again, which ends because its cycles
 * do. */
static uint32_t permute(uint32_t i, uint32_t count, uint64_t key)
{
    const uint32_t bits = 32 - (uint32_t)__builtin_clz(count - 1);
    const uint32_t mask = (uint32_t)((UINT64_C(1) << bits) - 1);
    const uint32_t half_bits = (bits + 1) / 2;
    do {
        i = scramble(i, mask, half_bits, key);
    } while (i >= count);
    return i;
}

/* Fisher-Yates, drawing from the high bits of a linear congruential generator (Knuth's MMIX). */
static void shuffle(uint8_t *order, uint32_t count, uint64_t state)
{
    for (uint32_t i = 0; i < count; i++) order[i] = (uint8_t)i;
    for (uint32_t i = count; i > 1; i--) {
        state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        const uint32_t pick = (uint32_t)((state >> 32) * i >> 32);
        const uint8_t card = order[pick];
        order[pick] = order[i - 1];
        order[i - 1] = card;
    }
}

void pattern_deck_init(struct pattern_deck *deck, const struct pattern *p, int32_t x, int32_t y,
                       uint32_t dimension, uint32_t l)
{
    const uint64_t offset = pixel_key(p, x, y, dimension);
    deck->order_key = mix(offset + PATTERN_GOLDEN_FRACTION);
    deck->jitter[0] = pattern_unit(offset);
    deck->jitter[1] = pattern_unit(offset << 32);
    deck->l = l;
    if (l * l <= PATTERN_DECK_CARDS) shuffle(deck->order, l * l, deck->order_key);
}

void pattern_deck_draw(const struct pattern_deck *deck, uint32_t i, float out[2])
{
    const uint32_t count = deck->l * deck->l;
    const uint32_t stratum =
        count <= PATTERN_DECK_CARDS ? deck->order[i] : permute(i, count, deck->order_key);
    pattern_stratum(deck->jitter, deck->l, stratum, out);
}

void pattern_shuffled(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension, uint32_t l,
                      uint32_t i, float out[2])
{
    struct pattern_deck deck;
    pattern_deck_init(&deck, p, x, y, dimension, l);
    pattern_deck_draw(&deck, i, out);
}

void pattern_pixels_init(const struct pattern *p, uint32_t count, struct pattern_pixels *out)
{
    lattice_init(p, PATTERN_PIXEL, &out->lattice);
    out->step = count > 1 ? UINT64_MAX / count : 0;
}

void pattern_pixel(const struct pattern *p, int32_t x, int32_t y, uint32_t k, uint32_t count,
                   float out[2])
{
    struct pattern_pixels pixels;
    pattern_pixels_init(p, count, &pixels);
    for (int axis = 0; axis < 2; axis++) out[axis] = pattern_pixels_at(&pixels, x, y, k, axis);
}
