#pragma once
/* Random numbers with fixed seeds: SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable
 * pseudorandom number generators"). */
#include <stdint.h>

struct random {
    uint64_t state;
};

static inline uint64_t random_bits(struct random *r)
{
    uint64_t v = r->state += UINT64_C(0x9e3779b97f4a7c15);
    v = (v ^ v >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    v = (v ^ v >> 27) * UINT64_C(0x94d049bb133111eb);
    return v ^ v >> 31;
}

/* In [0, 1), as the sampling patterns give them. */
static inline float random_unit(struct random *r)
{
    return (float)(random_bits(r) >> 40) * 0x1p-24f;
}
