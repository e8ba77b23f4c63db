/* The kernels of the filter of glossy lobes of every instruction set give the reference's bits.
 * A longer form, with times, is make check-kernels. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "proto/build.h"
#include "tests/kernel/kernel_glossy.h"

static void compare(const struct glossy_kernels *tested)
{
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct glossy_case k;
        glossy_case_init(&k, 9 + 11 * (int32_t)seed, 30 - 7 * (int32_t)seed, seed, seed != 4);
        for (enum glossy_kernel i = 0; i < GLOSSY_KERNEL_COUNT; i++)
            for (int32_t start = 0; start < 8; start += 7)
                assert_true(glossy_case_compare(&k, tested, i, start) == 0.0f);
        glossy_case_fini(&k);
    }
}

static void avx2(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "sse4.2") == 0) skip();
    compare(&glossy_kernels_avx2);
}

static void avx512(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "avx512") != 0) skip();
    compare(&glossy_kernels_avx512);
}

static void best_fits_the_cpu(void **state)
{
    (void)state;
    const struct glossy_kernels *best = glossy_kernels_best();
    assert_true(best == &glossy_kernels_c || best == &glossy_kernels_avx2 ||
                best == &glossy_kernels_avx512);
    compare(best);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(avx2),
        cmocka_unit_test(avx512),
        cmocka_unit_test(best_fits_the_cpu),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
