/* The kernels of the filters of indirect light of every instruction set give the reference's bits,
 * those of SSE4.2 nearly. A longer form, with times, is make check-kernels. */
#include "tests/kernel/kernel_indirect.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

static void compare(const struct indirect_kernels *tested)
{
    const bool rounds = tested == &indirect_kernels_sse42; /* then without extremes */
    const float most = rounds ? REFERENCE_ROUNDING : 0.0f;
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct indirect_case k;
        indirect_case_init(&k, 9 + 11 * (int32_t)seed, 30 - 7 * (int32_t)seed, seed,
                           !rounds && seed != 4);
        for (enum indirect_kernel i = 0; i < INDIRECT_KERNEL_COUNT; i++)
            for (int32_t start = 0; start < 8; start += 7)
                assert_true(indirect_case_compare(&k, tested, i, start) <= most);
        indirect_case_fini(&k);
    }
}

KERNEL_TESTS(indirect, compare)

/* Those for SSE4.2 round products, too. */
TEST(so_does_rounding_twice)
{
    compare(&indirect_kernels_sse42);
}
