/* The kernels of the filter of lens samples of every instruction set give the reference's bits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "proto/build.h"
#include "proto/lens_pattern.h"
#include "server/reconstruct/lens_field.h"

#define STRIDE  96
#define ROWS    24
#define TAPS    57
#define COUNT   48
#define NUMBERS 67 /* of a row: no multiple of any vector */

static float between(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) * 0x1p-24f;
}

static void compare_gather(const struct lens_kernels *tested, uint32_t seed)
{
    float *planes = malloc(LENS_CELL_PLANES * STRIDE * ROWS * sizeof *planes);
    float expected[LENS_GROUPS * LENS_SUMS * COUNT], result[LENS_GROUPS * LENS_SUMS * COUNT];
    struct lens_tap taps[TAPS];
    struct lens_gather gather = {.taps = taps, .inner = {5, 13, 13, 40}, .end = {13, 13, 40, TAPS}};
    for (size_t k = 0; k < LENS_CELL_PLANES; k++) {
        gather.plane[k] = planes + k * STRIDE * ROWS;
        for (size_t i = 0; i < STRIDE * ROWS; i++)
            planes[k * STRIDE * ROWS + i] =
                between(&seed, 0.0f, k == LENS_CELL_REACH ? 6.0f : 1.0f);
    }
    for (int t = 0; t < TAPS; t++) {
        taps[t].at = (t / 8 - 4) * STRIDE + t % 8 - 4;
        taps[t].distance = between(&seed, 0.0f, 6.0f);
    }
    lens_kernels_c.gather(&gather, 10 * STRIDE + 17, COUNT, expected, COUNT);
    tested->gather(&gather, 10 * STRIDE + 17, COUNT, result, COUNT);
    assert_memory_equal(expected, result, sizeof result);
    free(planes);
}

static void compare_place(const struct lens_kernels *tested, uint32_t seed, int32_t level)
{
    float arrays[6][NUMBERS];
    int32_t expected[NUMBERS], result[NUMBERS];
    static const float low[] = {-3.0f, -12.0f, -1.0f, -0.5f, 0.0f, -4.0f};
    static const float high[] = {3.0f, 12.0f, 0.0f, 1.0f, 2.0f, 4.0f};
    for (size_t k = 0; k < 6; k++)
        for (int i = 0; i < NUMBERS; i++) arrays[k][i] = between(&seed, low[k], high[k]);
    struct lens_place place = {.along = arrays[3],
                               .left = arrays[2],
                               .chord = arrays[4],
                               .height = arrays[0],
                               .slope = arrays[1],
                               .pass = arrays[5],
                               .stratum = 1.0f,
                               .strata_inverse = 1.0f / 3.0f,
                               .x = 1003,
                               .row_phase = level > 0 ? 1.0f : 0.0f,
                               .fine = level < 0 ? -level : 0,
                               .coarse = level > 0 ? level : 0,
                               .cells =
                                   level < 0 ? (float)(1 << -level) : 1.0f / (float)(1 << level),
                               .low = 3.0f,
                               .close = 2.25f,
                               .high = 8.0f,
                               .column = level < 0 ? 1010 << -level : 1010 >> level,
                               .row = -5,
                               .columns = 50,
                               .rows = 9,
                               .stride = 64,
                               .phase_step = 16};
    for (int32_t k = 0; k < 4; k++) {
        place.beyond = k & 1;
        place.fixed = k >> 1;
        for (uint32_t count = 1; count <= NUMBERS; count += 11) {
            lens_kernels_c.place(&place, count, expected);
            tested->place(&place, count, result);
            assert_memory_equal(expected, result, count * sizeof *result);
        }
    }
}

static void compare_lines(const struct lens_kernels *tested, uint32_t seed)
{
    float across[NUMBERS], expected[3][NUMBERS], result[3][NUMBERS];
    for (int i = 0; i < NUMBERS; i++) across[i] = between(&seed, 0.0f, 1.0f);
    for (uint32_t l = 1; l <= 16; l++)
        for (uint32_t i = 0; i < l; i++) {
            lens_disc_lines(l, i, NUMBERS, across, expected[0], expected[1], expected[2]);
            tested->lines(l, i, NUMBERS, across, result[0], result[1], result[2]);
            assert_memory_equal(expected, result, sizeof result);
        }
}

static void compare_layers(const struct lens_kernels *tested, uint32_t seed)
{
    float slope[NUMBERS];
    for (int i = 0; i < NUMBERS; i++) slope[i] = between(&seed, -30.0f, 30.0f);
    for (uint32_t count = 1; count <= NUMBERS; count++) {
        uint32_t expected = 0;
        for (uint32_t i = 0; i < count; i++) expected |= 1u << lens_layer_of(slope[i]);
        assert_int_equal(tested->layers(slope, count), expected);
    }
}

/* Slopes lie in the layers that they are said to lie in. */
static void layers_cover_all_slopes(void **state)
{
    (void)state;
    static const float slopes[] = {0.0f,  -0.0f,  0.99f,  1.0f,     -1.0f,     1.5f,       -1.5f,
                                   23.9f, 24.0f,  -24.0f, -23.9f,   6.0f,      -6.0f,      -5.99f,
                                   11.0f, -17.0f, 1e-30f, 65504.0f, -65504.0f, -0.9999999f};
    for (size_t k = 0; k < sizeof slopes / sizeof *slopes; k++)
        for (uint32_t layer = 0; layer < LENS_LAYERS; layer++) {
            float low, high;
            lens_layer_slopes(layer, &low, &high);
            const bool in = slopes[k] >= low && slopes[k] < high;
            if (in != (lens_layer_of(slopes[k]) == layer))
                fail_msg("slope %g and layer %u", (double)slopes[k], layer);
        }
}

static void compare(const struct lens_kernels *tested)
{
    for (uint32_t seed = 1; seed <= 20; seed++) {
        compare_gather(tested, seed);
        for (int32_t level = -2; level <= 2; level++) compare_place(tested, seed, level);
        compare_lines(tested, seed);
        compare_layers(tested, seed);
    }
}

static void reference(void **state)
{
    (void)state;
    compare(&lens_kernels_c);
}

/* What the reference places, computed for one sample after the other. */
static void places_are_projections(void **state)
{
    (void)state;
    const float slope[3] = {4.0f, 4.0f, 1.0f}, pass[3] = {5.0f, 5.0f, 5.0f}, along[3] = {0};
    const float left[3] = {0.5f, -0.5f, 0.25f}, chord[3] = {0}, height[3] = {0.25f, -0.5f, 1.0f};
    int32_t cell[3];
    struct lens_place place = {.slope = slope,
                               .pass = pass,
                               .along = along,
                               .left = left,
                               .chord = chord,
                               .height = height,
                               .strata_inverse = 1.0f,
                               .x = 10,
                               .cells = 1.0f,
                               .low = 3.0f,
                               .close = 2.0f,
                               .high = 8.0f,
                               .column = 0,
                               .row = -20,
                               .columns = 30,
                               .rows = 40,
                               .stride = 30};
    lens_kernels_c.place(&place, 3, cell);
    assert_int_equal(cell[0], 21 * 30 + 12); /* (10.5 + 4 / 2, 0.5 + 4 / 4) */
    assert_int_equal(cell[1], 18 * 30 + 9);  /* (11.5 - 2, 0.5 - 2) */
    assert_int_equal(cell[2], -1);
    place.beyond = 1;
    lens_kernels_c.place(&place, 3, cell);
    assert_int_equal(cell[0], -1);
    assert_int_equal(cell[2], 25 * 30 + 13); /* by a slope of 5 */
}

static void avx2(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "sse4.2") == 0) skip();
    compare(&lens_kernels_avx2);
}

static void avx512(void **state)
{
    (void)state;
    if (!build_isa() || strcmp(build_isa(), "avx512") != 0) skip();
    compare(&lens_kernels_avx512);
}

static void best_fits_the_cpu(void **state)
{
    (void)state;
    compare(lens_kernels_best());
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference),
        cmocka_unit_test(layers_cover_all_slopes),
        cmocka_unit_test(places_are_projections),
        cmocka_unit_test(avx2),
        cmocka_unit_test(avx512),
        cmocka_unit_test(best_fits_the_cpu),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
