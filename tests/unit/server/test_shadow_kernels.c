/* The shadow filters' kernels of every instruction set give the reference's bits. A longer form,
 * with times, is make check-kernels. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "proto/build.h"
#include "tests/kernel/kernel_field.h"

static void compare(const struct shadow_kernels *tested, uint32_t l, uint64_t seed)
{
    struct kernel_field k;
    field_init(&k, l, 15, 11, seed, seed % 4 != 3);
    for (enum kernel i = 0; i < KERNEL_COUNT; i++) {
        assert_true(field_compare(&k, tested, i, 0, k.count) == 0.0f);
        assert_true(field_compare(&k, tested, i, k.count / 3, 5) == 0.0f);
    }
    field_fini(&k);
}

static void all_strata(const struct shadow_kernels *tested)
{
    for (uint32_t l = 1; l <= SHADOW_STRATA_MAX; l++) compare(tested, l, l);
}

static void avx2(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "sse4.2") == 0) skip();
    all_strata(&shadow_kernels_avx2);
}

static void avx512(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "avx512") != 0) skip();
    all_strata(&shadow_kernels_avx512);
}

static void best_fits_the_cpu(void **state)
{
    (void)state;
    const struct shadow_kernels *best = shadow_kernels_best();
    assert_true(best == &shadow_kernels_c || best == &shadow_kernels_avx2 ||
                best == &shadow_kernels_avx512);
    all_strata(best);
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
