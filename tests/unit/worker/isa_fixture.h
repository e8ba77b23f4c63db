#pragma once
/* Instruction sets that lane kernels are compared on, and numbers to compare them by. */
#include <stdint.h>
#include <string.h>

#include "proto/build.h"

static const char *const all_isas[] = {"sse4.2", "avx2", "avx512"};

/* How many of them this CPU has; build_isa() names the best. */
static inline int isa_count(void)
{
    for (int i = 2; i >= 0; i--)
        if (strcmp(build_isa(), all_isas[i]) == 0) return i + 1;
    return 0;
}

static inline uint32_t random_bits(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 32);
}

/* In [0, 1). */
static inline float random_unit(uint64_t *state)
{
    return (float)(random_bits(state) >> 8) * 0x1p-24f;
}
