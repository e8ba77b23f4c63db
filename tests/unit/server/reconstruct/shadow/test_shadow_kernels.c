/* The shadow filters' kernels of every instruction set give the reference's bits, those of SSE4.2
 * nearly. A longer form, with times, is make check-kernels. */
#include "tests/kernel/kernel_field.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

static void compare(const struct shadow_kernels *tested, uint32_t l, uint64_t seed)
{
    const bool rounds = tested == &shadow_kernels_sse42; /* then without extremes */
    struct kernel_field k;
    field_init(&k, l, 15, 11, seed, !rounds && seed % 4 != 3);
    for (enum kernel i = 0; i < KERNEL_COUNT; i++) {
        const float most = rounds ? field_rounding(i) : 0.0f;
        assert_true(field_compare(&k, tested, i, 0, k.count) <= most);
        assert_true(field_compare(&k, tested, i, k.count / 3, 5) <= most);
    }
    field_fini(&k);
}

/* What `b` has of pixels that are not listed is what `a` has, in all planes. */
static void assert_others_same(const struct kernel_field *k, const struct shadow_pixels *a,
                               const struct shadow_pixels *b, const uint32_t *pixels,
                               uint32_t count)
{
    const size_t stride = field_stride(k);
    for (size_t i = 0, next = 0; i < stride; i++) {
        if (next < count && pixels[next] == i) {
            next++;
            continue;
        }
        for (size_t n = 0; n < FIELD_PIXEL; n++)
            assert_memory_equal(&a->point[0][n * stride + i], &b->point[0][n * stride + i],
                                sizeof(float));
    }
}

/* Those that write planes write the pixels they are asked for, and no other. */
static void keep_to_pixels(const struct shadow_kernels *tested)
{
    static const uint32_t counts[] = {1, 5, 15, 16, 17, 33, 100};
    struct kernel_field k;
    field_init(&k, 3, 15, 11, 1, true);
    const size_t bytes = FIELD_PIXEL * field_stride(&k) * sizeof(float);
    float *out = field_memory(FIELD_PIXEL * k.count * sizeof *out);
    struct shadow_pixels was;
    field_pixels(&was, field_stride(&k));
    memset(was.point[0], 0x3f, bytes);
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        uint32_t run[100];
        for (uint32_t i = 0; i < counts[c]; i++) run[i] = 1 + i; /* field_place */
        memcpy(k.placed.point[0], was.point[0], bytes);
        field_run(&k, tested, KERNEL_PLACE_RECEIVERS, 0, counts[c], out);
        assert_others_same(&k, &was, &k.placed, run, counts[c]);
        memcpy(k.sheared.point[0], k.shown.point[0], bytes);
        field_run(&k, tested, KERNEL_SHEAR_RECEIVERS, 7, counts[c], out);
        assert_others_same(&k, &k.shown, &k.sheared, k.pixels + 1 + 7, counts[c]);
    }
    free(was.point[0]);
    free(out);
    field_fini(&k);
}

/* What a walk gives a pixel does not depend on those beside it. */
static void each_by_itself(const struct shadow_kernels *tested, uint32_t l)
{
    static const enum kernel walks[] = {KERNEL_WALK_COLUMNS, KERNEL_WALK_ROWS};
    struct kernel_field k;
    field_init(&k, l, 15, 11, 5, true);
    for (size_t w = 0; w < 2; w++) {
        const size_t each = field_output(&k, walks[w], 1);
        float *all = field_memory(each * k.count * sizeof *all);
        float *one = field_memory(each * sizeof *one);
        field_run(&k, tested, walks[w], 0, k.count, all);
        for (uint32_t i = 0; i < k.count; i++) {
            field_run(&k, tested, walks[w], i, 1, one);
            assert_memory_equal(one, all + i * each, each * sizeof *one);
        }
        free(all);
        free(one);
    }
    field_fini(&k);
}

static void all_strata(const struct shadow_kernels *tested)
{
    for (uint32_t l = 1; l <= SHADOW_STRATA_MAX; l++) compare(tested, l, l);
    for (uint32_t l = 3; l <= SHADOW_STRATA_MAX; l += 6) each_by_itself(tested, l);
    keep_to_pixels(tested);
}

/* Those for SSE4.2 round products, too. */
TEST(so_does_rounding_twice)
{
    all_strata(&shadow_kernels_sse42);
}

/* Walks have room for that many. */
TEST(sums_of_all_strata_fit)
{
    uint32_t most = 0;
    for (uint32_t l = 1; l <= SHADOW_STRATA_MAX; l++) {
        const uint32_t each = l == 3 ? 8 : (l + 4) / 4 * 4; /* both nodes' of three */
        const uint32_t sums = shadow_phases(l, coverage_scale(l)) * each;
        most = sums > most ? sums : most;
    }
    assert_int_equal(most, SHADOW_SUMS_MAX);
}

KERNEL_TESTS(shadow, all_strata)
