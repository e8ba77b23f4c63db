#pragma once
/* Instruction sets that lane kernels are compared on. */
#include <string.h>

#include "proto/runtime/build.h"

static const char *const all_isas[] = {"sse4.2", "avx2", "avx512"};

/* How many of them this CPU has; build_isa() names the best. */
static inline int isa_count(void)
{
    for (int i = 2; i >= 0; i--)
        if (strcmp(build_isa(), all_isas[i]) == 0) return i + 1;
    return 0;
}
