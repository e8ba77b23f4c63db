/* Errors of means over paths: of independent samples what their spread says, of better ones what
 * halves say, and never anything that is no number. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/compose/path_error.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

#define SIDE 144
#define SPP  16

static struct patch *patch;
static struct block_variance variance;

static int set_up(void **state)
{
    struct plan plan;
    (void)state;
    synthetic_paths_plan(&plan, SIDE, SIDE, SIDE, SPP);
    const struct rect all = {0, 0, SIDE, SIDE};
    return patch_create(&plan, all, &patch) || block_variance_create(all, &variance);
}

static int tear_down(void **state)
{
    (void)state;
    patch_destroy(&patch);
    block_variance_fini(&variance);
    return 0;
}

EACH_TEST(set_up, tear_down);

/* Fills the patch from samples value(pixel, k); returns the mean of the means' squared errors over
 * the pixels, their expectation being 0. */
static double fill(float (*value)(size_t pixel, uint32_t k), uint32_t spp)
{
    const struct plan_pass pass = {.count = spp};
    const struct plan_split parts = plan_pass_split(&pass);
    struct patch *p = patch;
    double sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        double mean = 0, spread = 0, split = 0;
        for (uint32_t k = 0; k < spp; k++) mean += (double)value(i, k) / spp;
        for (uint32_t k = 0; k < spp; k++) spread += pow((double)value(i, k) - mean, 2);
        for (uint32_t k = 0; k < parts.length; k++)
            split += k < parts.length / 2 ? (double)value(i, k) : -(double)value(i, k);
        for (int c = 0; c < 3; c++) p->path_m2[c][i] = (float)spread;
        p->paths.spp[i] = (float)spp;
        p->path_half_difference2[i] = (float)(3 * split * split);
        p->paths.split_spp[i] = p->paths.split_length[i] = (float)parts.length;
        sum += mean * mean / (SIDE * SIDE);
    }
    return sum;
}

static double found(void)
{
    double sum = 0;
    assert_int_equal(path_error_find(patch, &variance), 0);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        assert_true(variance.by_source[ERROR_SOURCE_PATHS][1][i] >= 0.0f);
        assert_true(isfinite(variance.by_source[ERROR_SOURCE_PATHS][0][i]));
        sum += (double)variance.by_source[ERROR_SOURCE_PATHS][2][i] / (SIDE * SIDE);
    }
    return sum;
}

static float noise(size_t pixel, uint32_t k)
{
    return synthetic_random((int32_t)pixel, 3, k, 77) - 0.5f;
}

/* Each in its stratum of 16, in an order whose parts are stratified, too. */
static float stratified(size_t pixel, uint32_t k)
{
    const uint32_t pair = (k & 1) << 2 | (k & 2) | (k & 4) >> 2;
    const uint32_t turned = noise(pixel, 100 + pair) > 0.0f;
    const uint32_t reversed = pair << 1 | ((k >> 3) ^ turned);
    return ((float)reversed + noise(pixel, k) + 0.5f) / 16.0f - 0.5f;
}

static float constant(size_t pixel, uint32_t k)
{
    (void)pixel, (void)k;
    return 3.0f;
}

static float rare(size_t pixel, uint32_t k)
{
    return noise(pixel, k) > 0.45f ? 3.8f : -0.2f;
}

TEST(independent_samples_err_by_their_spread)
{
    static const uint32_t counts[] = {4, 9, 16, 64};
    for (size_t k = 0; k < 4; k++) {
        const double truth = fill(noise, counts[k]), estimate = found();
        assert_true(estimate > 0.8 * truth && estimate < 1.25 * truth);
    }
}

TEST(stratified_samples_err_less)
{
    const double alone = fill(noise, SPP), truth = fill(stratified, SPP), estimate = found();
    assert_true(truth < 0.05 * alone);
    assert_true(estimate < 0.1 * alone && estimate > 0.3 * truth && estimate < 4 * truth);
}

/* Most pixels have met nothing of what is rare; what is around them tells. */
TEST(rare_light_is_known_around)
{
    uint32_t far_off = 0;
    const double truth = fill(rare, 4), estimate = found();
    assert_true(estimate > 0.7 * truth && estimate < 1.4 * truth);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        double mean = 0;
        for (uint32_t k = 0; k < 4; k++) mean += (double)rare(i, k) / 4;
        far_off += mean * mean > 4 * (double)variance.by_source[ERROR_SOURCE_PATHS][0][i] + 1e-12;
    }
    assert_true(far_off < SIDE * SIDE / 10);
}

TEST(what_tells_nothing_is_nothing)
{
    fill(constant, SPP);
    assert_true(found() == 0.0);
    fill(noise, 1);
    assert_true(found() == 0.0);
    fill(noise, SPP);
    for (size_t i = 0; i < SIDE * SIDE; i++) patch->path_half_difference2[i] = 0.0f;
    assert_true(found() < 1e-4);
    for (size_t i = 0; i < SIDE * SIDE; i++) patch->path_half_difference2[i] = INFINITY;
    for (size_t i = 0; i < SIDE * SIDE; i++) patch->path_m2[2][i] = INFINITY;
    assert_true(isfinite(found()));
}

/* The pixels [x0, x1) x [y0, y1) of a patch without what lies beyond the halo. */
static struct patch *cut(struct rect block)
{
    struct plan plan;
    struct patch *part;
    synthetic_paths_plan(&plan, SIDE, SIDE, SIDE, SPP);
    const struct rect near = rect_grow(block, path_error_halo_px(&plan));
    assert_int_equal(patch_create(&plan, rect_intersect(near, patch->rect), &part), 0);
    for (int32_t y = part->rect.y0; y < part->rect.y1; y++)
        for (int32_t x = part->rect.x0; x < part->rect.x1; x++) {
            const size_t from = patch_pixel(patch, x, y), to = patch_pixel(part, x, y);
            for (int c = 0; c < 3; c++) part->path_m2[c][to] = patch->path_m2[c][from];
            part->paths.spp[to] = patch->paths.spp[from];
            part->path_half_difference2[to] = patch->path_half_difference2[from];
            part->paths.split_spp[to] = patch->paths.split_spp[from];
            part->paths.split_length[to] = patch->paths.split_length[from];
        }
    return part;
}

static float half_stratified(size_t pixel, uint32_t k)
{
    return pixel % SIDE < 90 ? stratified(pixel, k) : 2.0f * noise(pixel, k);
}

/* Blocks of any size that begin where cells do. */
TEST(blocks_do_not_show)
{
    static const int32_t sides[] = {32, 64, 96, 128};
    fill(half_stratified, SPP);
    found();
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++)
        for (int32_t y = 0; y < SIDE; y += sides[k])
            for (int32_t x = 0; x < SIDE; x += sides[k]) {
                struct block_variance part;
                const struct rect square = {x, y, x + sides[k], y + sides[k]};
                const struct rect block = rect_intersect(square, patch->rect);
                struct patch *near = cut(block);
                assert_int_equal(block_variance_create(block, &part), 0);
                assert_int_equal(path_error_find(near, &part), 0);
                for (int32_t v = block.y0; v < block.y1; v++)
                    assert_memory_equal(part.by_source[ERROR_SOURCE_PATHS][0] +
                                            block_variance_index(&part, block.x0, v),
                                        variance.by_source[ERROR_SOURCE_PATHS][0] +
                                            block_variance_index(&variance, block.x0, v),
                                        (size_t)rect_width(block) * sizeof(float));
                block_variance_fini(&part);
                patch_destroy(&near);
            }
}

/* Where the left third is stratified and the rest is not, errors at the border of a cell step no
 * more than they do within it. */
TEST(cells_do_not_show)
{
    double step[SIDE] = {0};
    fill(half_stratified, SPP);
    /* The same spread everywhere: what is left of steps is of the shares alone. */
    for (size_t i = 0; i < (size_t)SIDE * SIDE; i++)
        for (int c = 0; c < 3; c++) patch->path_m2[c][i] = 1.0f;
    found();
    for (int32_t x = 1; x < SIDE; x++)
        for (int32_t y = 0; y < SIDE; y++) {
            const float *square = variance.by_source[ERROR_SOURCE_PATHS][0];
            const size_t i = (size_t)y * SIDE + (size_t)x;
            assert_true(square[i] > 0.0f);
            step[x] += fabs(log((double)square[i] / (double)square[i - 1])) / SIDE;
        }
    double most = 0;
    for (int32_t x = 1; x < SIDE; x++)
        if (x % PATH_ERROR_CELL_PX != 0) most = fmax(most, step[x]);
    assert_true(most > 0.01); /* the shares do differ */
    for (int32_t x = PATH_ERROR_CELL_PX; x < SIDE; x += PATH_ERROR_CELL_PX)
        assert_true(step[x] <= 1.1 * most);
}
