/* The sheared filter's kernels of every instruction set give the reference's bits, those of SSE4.2
 * nearly. A longer form, with times, is make check-kernels. */
#include "tests/kernel/kernel_tests.h"
#include "tests/kernel/kernel_v_plane.h"
#include "tests/unit/unit.h"

static void compare(const struct v_plane_kernels *tested)
{
    const bool rounds = tested == &v_plane_kernels_sse42; /* then without extremes */
    const float most = rounds ? REFERENCE_ROUNDING : 0.0f;
    for (uint32_t l = 1; l <= V_PLANE_STRATA_MAX; l++) {
        struct v_plane_case k;
        v_plane_case_init(&k, l, 5 + 7 * (int32_t)(l % 6), l, !rounds && l % 4 != 3);
        for (enum v_plane_kernel i = 0; i < V_PLANE_KERNEL_COUNT; i++)
            assert_true(v_plane_case_compare(&k, tested, i) <= most);
        v_plane_case_fini(&k);
    }
}

/* What a pixel's columns add up to does not depend on those beside it. */
TEST(each_by_itself)
{
    struct v_plane_case k;
    v_plane_case_init(&k, 4, 23, 6, true);
    const size_t size = v_plane_case_output(&k);
    float *all = field_memory(size * sizeof *all), *one = field_memory(size * sizeof *one);
    v_plane_case_run(&k, KERNELS_BEST(v_plane_kernels), V_PLANE_COLUMNS, all);
    for (uint32_t i = 0; i < k.count; i++) {
        struct v_plane_case alone = k;
        const size_t at = (size_t)k.x[i] * V_PLANE_NODE_FLOATS;
        alone.x = &k.x[i];
        alone.count = 1;
        v_plane_case_run(&alone, KERNELS_BEST(v_plane_kernels), V_PLANE_COLUMNS, one);
        assert_memory_equal(one + at, all + at, V_PLANE_NODE_FLOATS * sizeof *one);
    }
    free(all);
    free(one);
    v_plane_case_fini(&k);
}

KERNEL_TESTS(v_plane, compare)

/* Those for SSE4.2 round products, too. */
TEST(so_does_rounding_twice)
{
    compare(&v_plane_kernels_sse42);
}
