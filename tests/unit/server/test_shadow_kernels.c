/* The shadow filters' kernels of every instruction set give the reference's bits. A longer form,
 * with times, is make check-kernels. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/kernel/kernel_field.h"
#include "tests/kernel/kernel_tests.h"

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

KERNEL_TESTS(shadow, all_strata)

int main(void)
{
    const struct CMUnitTest tests[] = {
        KERNEL_TESTS_OF_ALL,
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
