#pragma once
/* Sample positions: the one module that knows them. The worker samples by it, and filters in the
 * coordinator recompute from it where each sample lay.
 *
 * Everything is a pure function of (seed, frame, pixel, sample, dimension). A pixel has one jitter
 * per dimension, shared by its l x l strata (uniform jitter; docs/reconstruction.md, Sample
 * positions); the jitter runs over the pixel grid as an R2 sequence with a hashed origin, or as
 * Sobol points in Morton order with hashed Owen scrambling. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "proto/limits.h"

/* Uses of randomness; append-only. Each is two-dimensional and independent of the others. */
enum pattern_dimension {
    PATTERN_PIXEL = 0,           /* sub-pixel position of anti-aliasing rays */
    PATTERN_INDIRECT = 1,        /* direction of the first bounce */
    PATTERN_INDIRECT_CHOICE = 2, /* which light the bounce point samples (x) */
    PATTERN_INDIRECT_LIGHT = 3,  /* where on that light */
    PATTERN_LENS = 4,
    PATTERN_LIGHT = 16,      /* + light index: position on that light */
    PATTERN_LIGHT_NET = 128, /* + light index: the same where strata are many */
};

/* The dimension that places l x l strata on a light. Pixels' jitters are a lattice, and a filter's
 * shear turns them into another one, of any shape. Where the shear of one pixel is near half a
 * stratum, jitters of neighbours can come to lie on top of each other, wherever the picture has
 * that slope. Where strata are so narrow that this happens in wide penumbrae, jitters are a
 * scrambled net, which no shear can fold. */
#define PATTERN_NET_STRATA 6
_Static_assert(PATTERN_LIGHT + LIMIT_LIGHTS <= PATTERN_LIGHT_NET, "dimensions of their own");
static inline uint32_t pattern_light_dimension(uint32_t light, uint32_t l)
{
    return (l < PATTERN_NET_STRATA ? PATTERN_LIGHT : PATTERN_LIGHT_NET) + light;
}

struct pattern {
    uint64_t seed;
    uint32_t frame;
};

/* Computes the pixel's jitter in a dimension, both numbers in [0,1). */
void pattern_jitter(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension,
                    float out[2]);

/* Computes the jitters of `count` pixels at once, with pattern_jitter's two numbers each. */
void pattern_jitters(const struct pattern *p, const int32_t *x, const int32_t *y, uint32_t count,
                     uint32_t dimension, float *out0, float *out1);

/* A dimension's jitters where they are a lattice: what a pixel's coordinates are multiplied by, and
 * an origin, in 64-bit fractions that wrap. For loops that make many. */
struct pattern_lattice {
    uint64_t by[2][2], origin[2];
};

/* Returns false when the dimension is no lattice but a net. */
bool pattern_lattice_init(const struct pattern *p, uint32_t dimension, struct pattern_lattice *out);

static inline uint64_t pattern_lattice_phase(const struct pattern_lattice *l, int32_t x, int32_t y,
                                             int axis)
{
    const uint64_t px = (uint64_t)(int64_t)x, py = (uint64_t)(int64_t)y;
    return px * l->by[axis][0] + py * l->by[axis][1] + l->origin[axis];
}

/* Returns number `axis` of the pixel's jitter, as pattern_jitter has it. */
static inline float pattern_lattice_jitter(const struct pattern_lattice *l, int32_t x, int32_t y,
                                           int axis)
{
    return (float)(int32_t)(pattern_lattice_phase(l, x, y, axis) >> 40) * 0x1p-24f;
}

/* Keeps stratum + jitter below the next stratum after rounding, for 256 strata an axis. */
#define PATTERN_JITTER_MAX (65535.0f / 65536.0f)

/* Returns the position of stratum k of l along one axis, in [0,1). pattern_stratum combines two
 * axes. */
static inline float pattern_axis(float jitter, uint32_t l, uint32_t k)
{
    return ((float)k + (jitter < PATTERN_JITTER_MAX ? jitter : PATTERN_JITTER_MAX)) / (float)l;
}

/* Computes sample i of l x l in the dimension: ((i % l + j0) / l, (i / l + j1) / l), both in
 * [0,1). */
void pattern_stratum(const float jitter[2], uint32_t l, uint32_t i, float out[2]);

/* Computes sample i of l x l with the strata visited in an order hashed from pixel and dimension,
 * for dimensions that must not move in step with another one. Both in [0,1). */
void pattern_shuffled(const struct pattern *p, int32_t x, int32_t y, uint32_t dimension, uint32_t l,
                      uint32_t i, float out[2]);

/* All of a pixel's shuffled samples in a dimension: init once, then draw each for next to nothing.
 * pattern_deck_draw(deck, i, out) gives pattern_shuffled's numbers. */
#define PATTERN_DECK_CARDS 64 /* above, the order is computed card by card */
struct pattern_deck {
    uint64_t order_key;
    float jitter[2];
    uint32_t l;
    uint8_t order[PATTERN_DECK_CARDS];
};
void pattern_deck_init(struct pattern_deck *deck, const struct pattern *p, int32_t x, int32_t y,
                       uint32_t dimension, uint32_t l);
void pattern_deck_draw(const struct pattern_deck *deck, uint32_t i, float out[2]);

/* Computes the position of anti-aliasing ray k of `count` inside the pixel, in [0,1)^2; the primary
 * ray itself goes through (0.5, 0.5). */
void pattern_pixel(const struct pattern *p, int32_t x, int32_t y, uint32_t k, uint32_t count,
                   float out[2]);

/* Returns number `axis` of point k of `count` all over a pixel: a lattice by the golden ratio,
 * which the pixel's jitter shifts around. Along either axis the points are spaced evenly, so that
 * slivers along a pixel's border get their share. */
static inline float pattern_golden_at(const float jitter[2], uint32_t k, uint32_t count, int axis)
{
    const float along =
        axis == 0 ? ((float)k + 0.5f) / (float)count : (float)(k * 0x9e3779b9u >> 8) * 0x1p-24f;
    const float at = jitter[axis] + along, inside = at < 1.0f ? at : at - 1.0f;
    return inside < 0x1.fffffep-1f ? inside : 0x1.fffffep-1f;
}

/* What pattern_pixel needs of a frame, computed once for loops that place many rays. */
struct pattern_pixels {
    struct pattern_lattice lattice;
    uint64_t step; /* from ray to ray on the way around a pixel */
};
void pattern_pixels_init(const struct pattern *p, uint32_t count, struct pattern_pixels *out);

/* Spaces the radii of a pixel's anti-aliasing rays, and sets hashes apart: the golden ratio's
 * fraction. */
#define PATTERN_GOLDEN_FRACTION UINT64_C(0x9e3779b97f4a7c15)
#define PATTERN_BELOW_ONE       0x1.fffffep-1f

/* Converts by way of signed numbers, for which vectors have an instruction. */
static inline float pattern_unit(uint64_t fraction)
{
    return (float)(int32_t)(fraction >> 40) * 0x1p-24f;
}

/* Returns number `axis` of pattern_pixel's position: a point on the edge of a square around the
 * pixel's centre, counter-clockwise from its lower right corner. All edges are equally far from the
 * centre, so area grows evenly with the way along them, and with the square of the distance: rays
 * spaced evenly around the pixel, each still uniform over it. */
static inline float pattern_pixels_at(const struct pattern_pixels *p, int32_t x, int32_t y,
                                      uint32_t k, int axis)
{
    const uint64_t around = pattern_lattice_phase(&p->lattice, x, y, 0) + k * p->step;
    const uint64_t away = pattern_lattice_phase(&p->lattice, x, y, 1) + k * PATTERN_GOLDEN_FRACTION;
    const float along = 4.0f * pattern_unit(around);
    const int32_t side = (int32_t)along;
    const float turn = side & 2 ? -1.0f : 1.0f;
    const float t = (2.0f * (along - (float)side) - 1.0f) * turn;
    const float upright = axis == 0 ? turn : t, level = axis == 0 ? -t : turn;
    const float edge = side & 1 ? level : upright;
    const float at = 0.5f + 0.5f * sqrtf(pattern_unit(away)) * edge;
    return at < PATTERN_BELOW_ONE ? at : PATTERN_BELOW_ONE;
}
