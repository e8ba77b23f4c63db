/* The kernels of the filter of lens samples of every instruction set give the reference's bits. */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "proto/lens_pattern.h"
#include "server/reconstruct/lens/lens_field.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

#define STRIDE     96
#define ROWS       24
#define TAPS       57
#define COUNT      48
#define NUMBERS    67 /* of a row: no multiple of any vector */
#define ADD_ARRAYS 10
#define ALL_LANES  ((1u << LENS_LANES) - 1u)
#define ADD_CELLS  (64 * 9)
#define ADD_SUMS   (LENS_CELL_SUMS * (ADD_CELLS + LENS_LANES))

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
    lens_kernels_sse42.gather(&gather, 10 * STRIDE + 17, COUNT, expected, COUNT);
    tested->gather(&gather, 10 * STRIDE + 17, COUNT, result, COUNT);
    assert_memory_equal(expected, result, sizeof result);
    free(planes);
}

static void fill(uint32_t *seed, float low, float high, size_t count, float *out)
{
    for (size_t i = 0; i < count; i++) out[i] = between(seed, low, high);
}

/* A layer of slopes from 3 to 8, half of whose cells lie before `column`. */
static struct lens_splat splat_of(float arrays[ADD_ARRAYS][NUMBERS], int32_t level)
{
    return (struct lens_splat){.along = arrays[3],
                               .left = arrays[2],
                               .chord = arrays[4],
                               .height = arrays[0],
                               .slope = arrays[1],
                               .pass = arrays[5],
                               .known = arrays[6],
                               .light = {arrays[7], arrays[8], arrays[9]},
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
                               .spare = ADD_CELLS,
                               .phase_step = 16};
}

static void compare_add(const struct lens_kernels *tested, uint32_t seed, int32_t level)
{
    static const float low[] = {-3, -12, -1, -0.5f, 0, -4, -1, 0, 0, 0};
    static const float high[] = {3, 12, 0, 1, 2, 4, 1, 1, 2, 3};
    static _Alignas(16) float expected[ADD_SUMS], result[ADD_SUMS];
    float arrays[ADD_ARRAYS][NUMBERS];
    for (size_t k = 0; k < ADD_ARRAYS; k++) fill(&seed, low[k], high[k], NUMBERS, arrays[k]);
    struct lens_splat splat = splat_of(arrays, level);
    for (int32_t k = 0; k < 4; k++) {
        splat.beyond = k & 1;
        splat.fixed = k >> 1;
        for (uint32_t count = 1; count <= NUMBERS; count += 11) {
            fill(&seed, 0.0f, 1.0f, ADD_SUMS, expected);
            memcpy(result, expected, sizeof result);
            lens_kernels_sse42.add(&splat, count, expected);
            tested->add(&splat, count, result);
            assert_memory_equal(expected, result, ADD_CELLS * LENS_CELL_SUMS * sizeof *result);
        }
    }
}

static void compare_slopes(const struct lens_kernels *tested, uint32_t seed)
{
    float slope[NUMBERS], expected[3][NUMBERS], result[3][NUMBERS];
    fill(&seed, -4.0f, 4.0f, NUMBERS, slope);
    for (uint32_t count = 1; count <= NUMBERS; count += 11) {
        for (size_t k = 0; k < 3; k++) fill(&seed, -1.0f, 1.0f, NUMBERS, expected[k]);
        memcpy(result, expected, sizeof result);
        lens_kernels_sse42.slopes(slope, -1.0f, 2.0f, count, expected[0], expected[1]);
        tested->slopes(slope, -1.0f, 2.0f, count, result[0], result[1]);
        for (int32_t fixed = 0; fixed < 2; fixed++) {
            lens_kernels_sse42.passes(slope, expected[1], 3.0f, fixed, COUNT, expected[2]);
            tested->passes(slope, expected[1], 3.0f, fixed, COUNT, result[2]);
            assert_memory_equal(expected, result, 2 * sizeof *result + COUNT * sizeof(float));
        }
    }
}

static void compare_finish(const struct lens_kernels *tested, uint32_t seed)
{
    enum { CELLS = COUNT + 2 * LENS_LANES };
    static float expected[LENS_CELL_PLANES][CELLS], result[LENS_CELL_PLANES][CELLS];
    float sums[CELLS * LENS_CELL_SUMS];
    struct lens_finish finish = {.sums = sums, .inradius = 0.75f, .middle = 3.5f};
    for (size_t i = 0; i < CELLS * LENS_CELL_SUMS; i++)
        sums[i] = between(&seed, 0.0f, 1.0f) * (float)(seed >> 30 & 1u);
    for (finish.fixed = 0; finish.fixed < 2; finish.fixed++) {
        for (int k = 0; k < LENS_CELL_PLANES; k++) finish.plane[k] = expected[k];
        lens_kernels_sse42.finish(&finish, 7, COUNT);
        for (int k = 0; k < LENS_CELL_PLANES; k++) finish.plane[k] = result[k];
        tested->finish(&finish, 7, COUNT);
        assert_memory_equal(expected, result, sizeof result);
    }
}

/* Some pixels have nothing in focus, some nothing that light comes through. */
static void compare_focus(const struct lens_kernels *tested, uint32_t seed)
{
    float slope[2 * COUNT], light[6 * COUNT], views[2][LENS_VIEWS][COUNT];
    uint32_t listed[2][COUNT], n[2];
    struct lens_focus focus = {.slope = slope,
                               .light = light,
                               .area = COUNT,
                               .samples = 2,
                               .low = -1.0f,
                               .high = 1.0f,
                               .share = {0.2f, 0.3f, 0.4f, 0.1f}};
    fill(&seed, -3.0f, 3.0f, 2 * COUNT, slope);
    fill(&seed, 0.0f, 2.0f, 6 * COUNT, light);
    fill(&seed, -0.3f, 1.0f, LENS_VIEWS * COUNT, views[0][0]);
    memcpy(views[1], views[0], sizeof *views);
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < LENS_GROUPS; k++) focus.through[k] = views[i][LENS_VIEW_THROUGH + k];
        for (int k = 0; k < LENS_LIGHTS; k++) focus.lights[k] = views[i][LENS_VIEW_LIGHT + k];
        focus.shares = views[i][LENS_VIEW_SHARE];
        n[i] = (i ? tested : &lens_kernels_sse42)->focus(&focus, COUNT, listed[i]);
    }
    assert_int_equal(n[0], n[1]);
    assert_true(n[0] > 0 && n[0] < COUNT / 2);
    assert_memory_equal(listed[0], listed[1], n[0] * sizeof **listed);
    assert_memory_equal(views[0], views[1], sizeof *views);
}

static void compare_composite(const struct lens_kernels *tested, uint32_t seed)
{
    float sums[LENS_GROUPS * LENS_SUMS * LENS_LANES], views[2][LENS_VIEWS][LENS_LANES];
    float before[LENS_VIEWS][LENS_LANES];
    const struct lens_composite composite = {.sums = sums,
                                             .lens = {0.25f, 0.25f, 0.2f, 0.3f},
                                             .share = {0.2f, 0.3f, 0.4f, 0.1f},
                                             .slope = 3.5f,
                                             .near = seed % 2 ? ALL_LANES : 0x6ca5};
    for (size_t i = 0; i < sizeof sums / sizeof *sums; i++)
        sums[i] = between(&seed, 0.0f, 1.0f) * (float)(seed >> 30 & 1u);
    fill(&seed, 0.0f, 1.0f, LENS_VIEWS * LENS_LANES, views[0][0]);
    memcpy(views[1], views[0], sizeof *views);
    memcpy(before, views[0], sizeof before);
    lens_kernels_sse42.composite(&composite, views[0]);
    tested->composite(&composite, views[1]);
    assert_memory_equal(views[0], views[1], sizeof *views);
    for (int i = 0; i < LENS_LANES; i++)
        for (int k = 0; k < LENS_VIEWS && !(composite.near >> i & 1u); k++)
            assert_true(views[0][k][i] == before[k][i]);
    assert_true(memcmp(views[0], before, sizeof before) != 0);
}

static void compare_lines(const struct lens_kernels *tested, uint32_t seed)
{
    const uint32_t blades = seed % 2 ? 0 : 3 + seed % (LIMIT_LENS_BLADES - 2);
    const struct plan_camera camera = {.blade_count = blades,
                                       .blade_rotation_rad = 0.1f * (float)seed};
    struct lens_aperture aperture;
    float across[NUMBERS], expected[3][NUMBERS], result[3][NUMBERS];
    for (int i = 0; i < NUMBERS; i++) across[i] = between(&seed, 0.0f, 1.0f);
    across[0] = 0.0f;
    across[1] = 1.0f;
    lens_aperture_init(&camera, &aperture);
    for (uint32_t l = 1; l <= 16; l++)
        for (uint32_t i = 0; i < l; i++) {
            lens_aperture_lines(&aperture, l, i, NUMBERS, across, expected[0], expected[1],
                                expected[2]);
            tested->lines(&aperture, l, i, NUMBERS, across, result[0], result[1], result[2]);
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
TEST(layers_cover_all_slopes)
{
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
        for (int32_t level = -2; level <= 2; level++) compare_add(tested, seed, level);
        compare_slopes(tested, seed);
        compare_finish(tested, seed);
        compare_focus(tested, seed);
        compare_composite(tested, seed);
        compare_lines(tested, seed);
        compare_layers(tested, seed);
    }
}

TEST(reference)
{
    compare(&lens_kernels_sse42);
}

/* The reference, computed for one sample after the other. */
TEST(samples_lie_at_projections)
{
    enum { HIT = 21 * 30 + 12, OTHER = 18 * 30 + 9, PASSING = 25 * 30 + 13, CELLS = 30 * 40 };
    const float slope[3] = {4.0f, 4.0f, 1.0f}, pass[3] = {5.0f, 5.0f, 5.0f}, along[3] = {0};
    const float left[3] = {0.5f, -0.5f, 0.25f}, chord[3] = {0}, height[3] = {0.25f, -0.5f, 1.0f};
    const float known[3] = {0.0f, 0.0f, 2.0f}, light[3] = {1.0f, 2.0f, 3.0f};
    static _Alignas(16) float sums[CELLS + LENS_LANES][LENS_CELL_SUMS];
    struct lens_splat splat = {.slope = slope,
                               .pass = pass,
                               .known = known,
                               .light = {light, light, light},
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
                               .spare = CELLS,
                               .stride = 30};
    const float first[] = {1, 1, 1, 3, 1, 4, 1, 1};   /* at (10.5 + 4 / 2, 0.5 + 4 / 4) */
    const float second[] = {2, 2, 2, 12, 1, 4, 1, 1}; /* at (11.5 - 2, 0.5 - 2) */
    const float third[] = {0, 0, 0, 0, 0, 5, 1, 1};   /* by a slope of 5 */
    lens_kernels_sse42.add(&splat, 3, sums[0]);
    assert_memory_equal(sums[HIT], first, sizeof first);
    assert_memory_equal(sums[OTHER], second, sizeof second);
    assert_true(sums[PASSING][6] == 0.0f);
    splat.beyond = 1;
    lens_kernels_sse42.add(&splat, 3, sums[0]);
    assert_memory_equal(sums[HIT], first, sizeof first);
    assert_memory_equal(sums[PASSING], third, sizeof third);
}

KERNEL_TESTS(lens, compare)
