#pragma once
/* The tests that all tables of kernels have: those of AVX2 and later give the reference's bits, and
 * the CPU gets its own. For a file with KERNEL_TESTS(NAME, compare) at its top level, where
 * `compare` takes a table, struct NAME_kernels, and asserts what must hold of it. */
#include <stdbool.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "tests/unit/unit.h"

static inline bool cpu_runs(const char *isa)
{
    const char *best = build_isa();
    return best && (strcmp(best, isa) == 0 || strcmp(best, "avx512") == 0);
}

#define KERNEL_TESTS(NAME, compare)                                                                \
    TEST(avx2_agrees)                                                                              \
    {                                                                                              \
        if (!cpu_runs("avx2")) skip();                                                             \
        compare(&NAME##_kernels_avx2);                                                             \
    }                                                                                              \
    TEST(avx512_agrees)                                                                            \
    {                                                                                              \
        if (!cpu_runs("avx512")) skip();                                                           \
        compare(&NAME##_kernels_avx512);                                                           \
    }                                                                                              \
    TEST(best_fits_the_cpu)                                                                        \
    {                                                                                              \
        assert_ptr_equal(KERNELS_BEST(NAME##_kernels), cpu_runs("avx512") ? &NAME##_kernels_avx512 \
                                                       : cpu_runs("avx2")                          \
                                                           ? &NAME##_kernels_avx2                  \
                                                           : &NAME##_kernels_sse42);               \
    }
