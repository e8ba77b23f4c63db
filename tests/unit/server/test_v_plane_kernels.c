/* The sheared filter's kernels of every instruction set give the reference's bits. A longer form,
 * with times, is make check-kernels. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "proto/build.h"
#include "tests/kernel/kernel_v_plane.h"

static void compare(const struct v_plane_kernels *tested)
{
    for (uint32_t l = 1; l <= V_PLANE_STRATA_MAX; l++) {
        struct v_plane_case k;
        v_plane_case_init(&k, l, 5 + 7 * (int32_t)(l % 6), l, l % 4 != 3);
        for (enum v_plane_kernel i = 0; i < V_PLANE_KERNEL_COUNT; i++)
            assert_true(v_plane_case_compare(&k, tested, i) == 0.0f);
        v_plane_case_fini(&k);
    }
}

static void avx2(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "sse4.2") == 0) skip();
    compare(&v_plane_kernels_avx2);
}

static void avx512(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "avx512") != 0) skip();
    compare(&v_plane_kernels_avx512);
}

static void best_fits_the_cpu(void **state)
{
    (void)state;
    const struct v_plane_kernels *best = v_plane_kernels_best();
    assert_true(best == &v_plane_kernels_c || best == &v_plane_kernels_avx2 ||
                best == &v_plane_kernels_avx512);
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
