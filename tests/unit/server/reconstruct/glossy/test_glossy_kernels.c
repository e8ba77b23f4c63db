/* The kernels of the filter of glossy lobes of every instruction set give the reference's bits,
 * those of SSE4.2 nearly. A longer form, with times, is make check-kernels. */
#include "tests/kernel/kernel_glossy.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

static void compare(const struct glossy_kernels *tested)
{
    const bool rounds = tested == &glossy_kernels_sse42; /* then without extremes */
    const float most = rounds ? REFERENCE_ROUNDING : 0.0f;
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct glossy_case k;
        glossy_case_init(&k, 9 + 11 * (int32_t)seed, 30 - 7 * (int32_t)seed, seed,
                         !rounds && seed != 4);
        for (uint32_t i = 0; i < GLOSSY_KERNEL_COUNT; i++)
            for (int32_t start = 0; start < 8; start += 7)
                assert_true(glossy_case_compare(&k, tested, i, start) <= most);
        glossy_case_fini(&k);
    }
}

KERNEL_TESTS(glossy, compare)

/* Those for SSE4.2 round products, too. */
TEST(so_does_rounding_twice)
{
    compare(&glossy_kernels_sse42);
}
