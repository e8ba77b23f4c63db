#pragma once
/* Random numbers of the path tracer: pairs in [0, 1)^2 for (pixel, sample, dimension).
 *
 * Each dimension of a pixel is the two-dimensional Sobol' sequence in an order and with a
 * scrambling of its own (Owen 1995; hashed as in Burley 2020, "Practical hash-based Owen
 * scrambling"), so that any power of two of consecutive samples is stratified in each pair, passes
 * continue each other, and no table is needed. Pure arithmetic on 32 bits: loops over lanes become
 * vector code.
 *
 * A filter never needs to know these positions; the light fields' are in pattern.h. */
#include <stdint.h>

/* What a pair is used for; at scattering v (0 is the camera's) PATH_VERTEX + v * PATH_PER_VERTEX +
 * one of the offsets. */
enum path_dimension {
    PATH_PIXEL = 0,     /* position in the pixel */
    PATH_LENS = 1,      /* position on the lens */
    PATH_OCCLUSION = 2, /* direction of the ambient occlusion ray */
    PATH_PRODUCT = 3,   /* first: which of the first surface's light samples is traced */
    PATH_VERTEX = 4,
    PATH_PER_VERTEX = 4,
    PATH_DIRECTION = 0, /* where the path goes on */
    PATH_LIGHT = 1,     /* position on the light */
    PATH_CHOICE = 2,    /* first: which lobe; second: which light */
    PATH_COLOR = 1024,  /* first: which colour dispersed volumes transmit; beyond all vertices */
    PATH_TIME = 1025,   /* first: when, while the shutter is open */
    PATH_GUIDE = 1026,  /* and on, one a scattering: which light behind glass, which texel of it */
    PATH_ROULETTE = 3,  /* first: whether the path goes on; second: which texel or triangle */
};

/* Mixes 32 bits, so that each depends on all (lowbias32 of Wellons 2018). */
static inline uint32_t path_mix(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

/* Returns the next number in [0, 1) of a plain sequence, for what is sampled before any path is. */
static inline float path_next(uint32_t *state)
{
    *state += 0x9e3779b9u;
    return (float)(path_mix(*state) >> 8) * 0x1p-24f;
}

static inline uint32_t path_reverse(uint32_t x)
{
    x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x00ff00ffu) << 8 | (x >> 8 & 0x00ff00ffu);
    return x << 16 | x >> 16;
}

/* Permutes numbers so that a bit depends on lower bits only. On reversed numbers this is what Owen
 * scrambling does (form of Laine and Karras 2011, constants of Vegdahl 2021). */
static inline uint32_t path_permute(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Returns the second Sobol' dimension's digits, lowest first. Bit j is the sum modulo 2 of all bits
 * b of x for which the binomial b over j is odd, which by Lucas is where j's bits are among b's. */
static inline uint32_t path_pascal(uint32_t x)
{
    x ^= x >> 1 & 0x55555555u;
    x ^= x >> 2 & 0x33333333u;
    x ^= x >> 4 & 0x0f0f0f0fu;
    x ^= x >> 8 & 0x00ff00ffu;
    return x ^ x >> 16;
}

static inline float path_unit(uint32_t bits)
{
    return (float)(int32_t)(bits >> 8) * 0x1p-24f;
}

/* The seeds that scramble a pixel's pairs in a dimension. */
struct path_seeds {
    uint32_t order, u, v;
};

static inline struct path_seeds path_seeds_of(uint32_t key, uint32_t dimension)
{
    const uint32_t seed = path_mix(key ^ dimension * 0x9e3779b9u);
    return (struct path_seeds){seed, path_mix(seed + 0x68bc21ebu), path_mix(seed + 0x02e5be93u)};
}

static inline void path_seeded_pair(struct path_seeds seeds, uint32_t sample, float *u, float *v)
{
    const uint32_t index = path_reverse(path_permute(path_reverse(sample), seeds.order));
    *u = path_unit(path_reverse(path_permute(index, seeds.u)));
    *v = path_unit(path_reverse(path_permute(path_pascal(index), seeds.v)));
}

/* Computes the pair of sample `sample` in `dimension`, for the pixel that path_key named. */
static inline void path_pair(uint32_t key, uint32_t sample, uint32_t dimension, float *u, float *v)
{
    path_seeded_pair(path_seeds_of(key, dimension), sample, u, v);
}

/* What a ray is for, as far as its random numbers at blended surfaces go. */
enum path_ray { PATH_RAY_NEXT = 1, PATH_RAY_SHADOW = 2, PATH_RAY_OCCLUSION = 3 };

/* Returns the key of a ray after `depth` scatterings; never 0. */
static inline uint32_t path_ray_key(uint32_t key, uint32_t sample, uint32_t depth,
                                    enum path_ray ray)
{
    return path_mix(path_mix(key + 0x27d4eb2fu * (uint32_t)ray) ^ (sample << 8 | depth)) | 1u;
}

/* Returns a pixel's key. */
static inline uint32_t path_key(uint64_t seed, uint32_t frame, int32_t x, int32_t y)
{
    uint32_t h = path_mix((uint32_t)seed + 0x9e3779b9u);
    h = path_mix(h ^ (uint32_t)(seed >> 32));
    h = path_mix(h ^ frame * 0x85ebca6bu);
    h = path_mix(h ^ (uint32_t)x);
    return path_mix(h + (uint32_t)y * 0xc2b2ae35u);
}

/* Spreads the low 16 bits to even places, for a pixel's place along the Morton curve, which visits
 * neighbours one after the other. */
static inline uint32_t path_spread_bits(uint32_t x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

static inline uint32_t path_morton(int32_t x, int32_t y)
{
    return path_spread_bits((uint32_t)x) | path_spread_bits((uint32_t)y) << 1;
}

/* Pixels of a square whose paths share one sequence. Pixel i of the curve through it has samples
 * i 2^k to (i + 1) 2^k - 1, so that neighbours make up for each other's gaps, whatever of them a
 * filter takes together (Ahmed and Wonka 2020, "Screen-space blue-noise diffusion of Monte Carlo
 * sampling error via hierarchical ordering of pixels"). A pixel's samples in themselves are what
 * they would be alone. */
#define PATH_SQUARE_PX 64

/* A pixel's part of its square's sequence. Samples beyond 2^k have another sequence. */
struct path_places {
    uint32_t square; /* key */
    uint32_t first;  /* sample */
    uint32_t digits; /* k */
};

static inline struct path_places path_places_of(uint64_t seed, uint32_t frame, int32_t x, int32_t y,
                                                uint32_t spp)
{
    uint32_t digits = 0;
    while (digits < 16 && 1u << digits < spp) digits++;
    const int32_t low = PATH_SQUARE_PX - 1;
    return (struct path_places){path_key(seed, frame, x & ~low, y & ~low),
                                path_morton(x & low, y & low) << digits, digits};
}

/* Does the same for pixels that have 2^more times as many samples, from a sequence of their own. */
static inline struct path_places path_edge_places_of(uint64_t seed, uint32_t frame, int32_t x,
                                                     int32_t y, uint32_t spp, uint32_t more)
{
    struct path_places p = path_places_of(seed, frame, x, y, spp);
    if (more == 0) return p;
    p.square = path_mix(p.square + 0x1f83d9abu);
    p.first <<= more;
    p.digits += more;
    return p;
}

static inline uint32_t path_place_key(struct path_places p, uint32_t sample)
{
    const uint32_t turn = sample >> p.digits;
    return turn > 0 ? path_mix(p.square + turn * 0x9e3779b9u) : p.square;
}

static inline uint32_t path_place_sample(struct path_places p, uint32_t sample)
{
    return p.first | (sample & ((1u << p.digits) - 1));
}

/* Returns the key of the sequence that all pixels of a frame share for their glossy lobes. Pixel i
 * of the curve has samples i n to i n + n - 1, so that neighbours make up for each other's gaps
 * (docs/reconstruction.md, Sample positions: half the samples' worth). */
static inline uint32_t path_frame_key(uint64_t seed, uint32_t frame)
{
    uint32_t h = path_mix((uint32_t)seed + 0x3c6ef372u);
    h = path_mix(h ^ (uint32_t)(seed >> 32));
    return path_mix(h ^ frame * 0x85ebca6bu);
}

/* Returns the key of a pixel's paths that leave its glossy lobe. */
static inline uint32_t path_glossy_key(uint32_t pixel_key)
{
    return path_mix(pixel_key + 0x510e527fu);
}

/* Returns the key of the same pixel's light field of indirect light. Its paths must not share
 * numbers with those that the camera sends through the pixel, to which they are added. */
static inline uint32_t path_field_key(uint32_t pixel_key)
{
    return path_mix(pixel_key + 0x7f4a7c15u);
}
