/* The kernels of the filter of lens samples of every instruction set give the reference's bits. */
#include "proto/lens_pattern.h"
#include "server/reconstruct/lens/lens_field.h"
#include "tests/kernel/kernel_lens.h"
#include "tests/kernel/kernel_tests.h"
#include "tests/unit/unit.h"

#define COUNT     48
#define NUMBERS   67 /* of a row: no multiple of any vector */
#define ALL_LANES ((1u << SIMD_LANES) - 1u)

static float between(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) * 0x1p-24f;
}

static void fill(uint32_t *seed, float low, float high, size_t count, float *out)
{
    for (size_t i = 0; i < count; i++) out[i] = between(seed, low, high);
}

/* Looking at a layer, and adding to one. */
static void compare_cells(const struct lens_kernels *tested, uint32_t seed, int32_t level)
{
    struct lens_case k;
    lens_case_init(&k, 1 + (int32_t)(11 * seed) % NUMBERS, 3, seed, level);
    for (enum lens_kernel i = 0; i < LENS_KERNEL_COUNT; i++)
        assert_true(lens_case_compare(&k, tested, i) == 0.0f);
    lens_case_fini(&k);
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
    enum { CELLS = COUNT + 2 * SIMD_LANES };
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
    float sums[LENS_GROUPS * LENS_SUMS * SIMD_LANES], views[2][LENS_VIEWS][SIMD_LANES];
    float before[LENS_VIEWS][SIMD_LANES];
    const struct lens_composite composite = {.sums = sums,
                                             .lens = {0.25f, 0.25f, 0.2f, 0.3f},
                                             .share = {0.2f, 0.3f, 0.4f, 0.1f},
                                             .slope = 3.5f,
                                             .near = seed % 2 ? ALL_LANES : 0x6ca5};
    for (size_t i = 0; i < sizeof sums / sizeof *sums; i++)
        sums[i] = between(&seed, 0.0f, 1.0f) * (float)(seed >> 30 & 1u);
    fill(&seed, 0.0f, 1.0f, LENS_VIEWS * SIMD_LANES, views[0][0]);
    memcpy(views[1], views[0], sizeof *views);
    memcpy(before, views[0], sizeof before);
    lens_kernels_sse42.composite(&composite, views[0]);
    tested->composite(&composite, views[1]);
    assert_memory_equal(views[0], views[1], sizeof *views);
    for (int i = 0; i < SIMD_LANES; i++)
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
        for (int32_t level = -2; level <= 2; level++) compare_cells(tested, seed, level);
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
    static _Alignas(16) float sums[CELLS + SIMD_LANES][LENS_CELL_SUMS];
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
