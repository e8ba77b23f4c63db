/* What the filters of lens samples must do whatever they are given. */
#include <stdlib.h>

#include "tests/unit/server/reconstruct/lens/lens_scene.h"
#include "tests/unit/unit.h"

#define AREA ((size_t)LENS_SIDE * LENS_SIDE)

static const uint32_t filters[] = {LENS_FILTER_NONE, LENS_FILTER_AXIS_ALIGNED, LENS_FILTER_SHEARED};

/* Slopes of all kinds, without any sense. */
static void scatter_slopes(struct lens_picture *p, uint32_t l)
{
    static const float kinds[] = {0.0f,   -0.0f, 0.4f,  -0.9f,  1.0f,   -1.0f,
                                  1.3f,   -1.6f, 2.5f,  -3.5f,  7.9f,   8.0f,
                                  -13.0f, 23.9f, 24.0f, -24.0f, 300.0f, -65504.0f};
    uint32_t state = 7;
    for (size_t i = 0; i < l * l * AREA; i++) {
        state = state * 1664525u + 1013904223u;
        p->patch.lens_slope[i] = kinds[(state >> 16) % (sizeof kinds / sizeof *kinds)];
    }
}

TEST(constants_stay)
{
    static const float values[] = {1.0f, 0.0f, 0.25f, 4096.0f, 0.3f, 1e-4f, 1e5f};
    for (uint32_t l = 1; l <= 4; l += 3) {
        struct lens_picture p;
        lens_picture_create(LENS_FENCE, l, 5, &p);
        for (size_t k = 0; k < 2 * sizeof values / sizeof *values; k++) {
            const float value = values[k / 2];
            if (k == 1) scatter_slopes(&p, l);
            for (size_t i = 0; i < l * l * 3 * AREA; i++) p.patch.lens_radiance[i] = value;
            for (size_t f = 0; f < 3; f++) {
                struct lens_statistics statistics;
                assert_int_equal(lens_run(&p, filters[f], &statistics), 0);
                assert_int_equal(statistics.pixels_filtered + statistics.pixels_skipped, AREA);
                const bool exact = k < 8 && f != 1;
                for (size_t i = 0; i < 3 * AREA; i++) {
                    const float off = fabsf(p.out[0][i] - value);
                    if (exact ? off != 0.0f : off > 2e-6f * value)
                        fail_msg("%g became %.9g under filter %zu", (double)value,
                                 (double)p.out[0][i], f);
                }
            }
        }
        lens_picture_destroy(&p);
    }
}

/* Any slopes, any light, no pixel that is not finite or that lies outside of what samples are. */
TEST(results_lie_among_samples)
{
    struct lens_picture p;
    lens_picture_create(LENS_LAMPS, 3, 0, &p);
    scatter_slopes(&p, 3);
    for (size_t i = 0; i < 27 * AREA; i += 97) p.patch.lens_radiance[i] = 1e12f;
    for (size_t f = 0; f < 3; f++) {
        struct lens_statistics statistics;
        assert_int_equal(lens_run(&p, filters[f], &statistics), 0);
        for (size_t i = 0; i < 3 * AREA; i++)
            assert_true(p.out[0][i] >= 0.0f && p.out[0][i] <= 1.0001e12f);
    }
    lens_picture_destroy(&p);
}

/* The filter adds up squares. */
TEST(the_brightest_samples_stay_finite)
{
    struct lens_picture p;
    lens_picture_create(LENS_LAMPS, 3, 0, &p);
    scatter_slopes(&p, 3);
    for (size_t i = 0; i < 27 * AREA; i++)
        if (i % 7 < 3) p.patch.lens_radiance[i] = LENS_RADIANCE_MAX;
    for (size_t f = 0; f < 3; f++) {
        struct lens_statistics statistics;
        assert_int_equal(lens_run(&p, filters[f], &statistics), 0);
        for (size_t i = 0; i < 3 * AREA; i++)
            assert_true(p.out[0][i] >= 0.0f && p.out[0][i] <= 1.0001f * LENS_RADIANCE_MAX);
    }
    lens_picture_destroy(&p);
}

/* Light of another unit gives the same picture in that unit. */
TEST(scale_is_of_no_account)
{
    static const float scales[] = {0x1p-13f, 0x1p17f};
    struct lens_picture p;
    lens_picture_create(LENS_FENCE, 3, 0, &p);
    float *first = malloc(3 * AREA * sizeof *first);
    struct lens_statistics statistics;
    assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
    memcpy(first, p.out[0], 3 * AREA * sizeof *first);
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < 27 * AREA; i++) p.patch.lens_radiance[i] *= scales[k];
        assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
        for (size_t i = 0; i < 3 * AREA; i++) assert_true(p.out[0][i] == first[i] * scales[k]);
        for (size_t i = 0; i < 27 * AREA; i++) p.patch.lens_radiance[i] /= scales[k];
    }
    free(first);
    lens_picture_destroy(&p);
}

TEST(what_is_in_focus_is_averaged)
{
    struct lens_picture p;
    lens_picture_create(LENS_FENCE, 2, 0, &p);
    for (size_t i = 0; i < 4 * AREA; i++) p.patch.lens_slope[i] = i % 2 ? 0.2f : -0.29f;
    float *average = malloc(3 * AREA * sizeof *average);
    struct lens_statistics statistics;
    for (size_t f = 0; f < 3; f++) {
        assert_int_equal(lens_run(&p, filters[f], &statistics), 0);
        assert_int_equal(statistics.pixels_skipped, AREA);
        if (f == 0) memcpy(average, p.out[0], 3 * AREA * sizeof *average);
        assert_memory_equal(average, p.out[0], 3 * AREA * sizeof *average);
        for (size_t i = 0; i < AREA; i++) assert_true(p.out[3][i] == 0.0f);
    }
    assert_int_equal(statistics.blocks_skipped, 1);
    free(average);
    lens_picture_destroy(&p);
}

/* Rays that meet nothing bring nothing, and so does the picture. */
TEST(nothing_is_black)
{
    struct lens_picture p;
    lens_picture_create(LENS_FENCE, 3, 0, &p);
    memset(p.patch.lens_radiance, 0, 27 * AREA * sizeof(float));
    for (size_t i = 0; i < 9 * AREA; i++) p.patch.lens_slope[i] = -7.0f;
    struct lens_statistics statistics;
    assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
    assert_int_equal(statistics.pixels_filtered, AREA);
    for (size_t i = 0; i < 3 * AREA; i++) assert_true(p.out[0][i] == 0.0f);
    lens_picture_destroy(&p);
}

/* What a block's patch holds of the picture's. */
static void cut(const struct lens_picture *p, struct rect rect, struct patch *out)
{
    const size_t width = (size_t)rect_width(rect), area = (size_t)rect_area(rect);
    const size_t n = (size_t)p->plan.lens_strata_per_axis * p->plan.lens_strata_per_axis;
    *out = (struct patch){.rect = rect, .core = rect};
    out->lens_radiance = malloc(3 * n * area * sizeof(float));
    out->lens_slope = malloc(n * area * sizeof(float));
    for (size_t k = 0; k < 4 * n; k++) {
        const float *from = k < 3 * n ? p->patch.lens_radiance + k * AREA
                                      : p->patch.lens_slope + (k - 3 * n) * AREA;
        float *to =
            k < 3 * n ? out->lens_radiance + k * area : out->lens_slope + (k - 3 * n) * area;
        for (int32_t y = rect.y0; y < rect.y1; y++)
            memcpy(to + (size_t)(y - rect.y0) * width, from + y * LENS_SIDE + rect.x0,
                   width * sizeof(float));
    }
}

/* Filters a block by itself and compares it with the whole picture. */
static void compare_block(const struct lens_picture *p, struct rect inner)
{
    struct lens_statistics statistics = {0};
    struct patch patch;
    cut(p, rect_intersect(rect_grow(inner, lens_halo_px(&p->plan)), p->patch.rect), &patch);
    const size_t area = (size_t)rect_area(patch.rect);
    float *memory = calloc(4 * area, sizeof *memory);
    float *const out[4] = {memory, memory + area, memory + 2 * area, memory + 3 * area};
    assert_int_equal(lens_filter(&p->plan, &patch, inner, out, out[3], &statistics), 0);
    for (int k = 0; k < 4; k++)
        for (int32_t y = inner.y0; y < inner.y1; y++)
            assert_memory_equal(out[k] + patch_pixel(&patch, inner.x0, y),
                                p->out[k] + y * LENS_SIDE + inner.x0,
                                (size_t)rect_width(inner) * sizeof(float));
    free(memory);
    free(patch.lens_radiance);
    free(patch.lens_slope);
}

TEST(blocks_do_not_matter)
{
    static const struct rect blocks[] = {
        {0, 0, 16, 16}, {16, 0, 48, 32}, {33, 47, 34, 48}, {1, 50, 96, 57}, {70, 71, 96, 96}};
    static const uint32_t strata[] = {2, 3, 6};
    for (size_t scene = 0; scene < 2 * LENS_SCENES; scene++)
        for (size_t f = 0; f < 3; f++) {
            struct lens_picture p;
            struct lens_statistics statistics;
            lens_picture_create((enum lens_scene)(scene % LENS_SCENES), strata[scene % 3],
                                scene % 2 ? 5 : 0, &p);
            if (scene >= LENS_SCENES) scatter_slopes(&p, strata[scene % 3]);
            assert_int_equal(lens_run(&p, filters[f], &statistics), 0);
            for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++)
                compare_block(&p, blocks[k]);
            lens_picture_destroy(&p);
        }
}

TEST(one_pixel_is_its_average)
{
    struct lens_picture p;
    struct lens_statistics statistics = {0};
    lens_picture_create(LENS_LAMPS, 3, 6, &p);
    p.plan.width_px = p.plan.height_px = 1;
    p.patch.rect = p.patch.core = (struct rect){0, 0, 1, 1};
    for (size_t f = 0; f < 3; f++) {
        float pixel[4], *const out[4] = {pixel, pixel + 1, pixel + 2, pixel + 3};
        double sum = 0.0;
        for (size_t j = 0; j < 9; j++) sum += (double)p.patch.lens_radiance[3 * j];
        p.plan.lens_filter = filters[f];
        assert_int_equal(lens_filter(&p.plan, &p.patch, p.patch.rect, out, out[3], &statistics), 0);
        assert_true(fabs((double)pixel[0] - sum / 9.0) < 1e-5 * sum);
    }
    lens_picture_destroy(&p);
}

/* A lamp far out of focus shows the aperture's shape, evenly lit and the right way up. */
TEST(lamps_show_the_aperture)
{
    const float slope = -15.0f, at = 0.5f * LENS_SIDE;
    struct lens_picture p;
    struct lens_statistics statistics;
    lens_picture_create(LENS_LAMPS, 4, 3, &p);
    p.plan.camera.blade_rotation_rad = 0.5f;
    for (size_t i = 0; i < AREA; i++)
        for (uint32_t j = 0; j < 16; j++) {
            const float x = (float)(i % LENS_SIDE) + 0.5f, y = (float)(i / LENS_SIDE) + 0.5f;
            float u[2];
            lens_pattern_point(&p.plan, (int32_t)(i % LENS_SIDE), (int32_t)(i / LENS_SIDE), j / 4,
                               j % 4, u);
            const float dx = x + slope * u[0] - at, dy = y + slope * u[1] - at;
            p.patch.lens_slope[j * AREA + i] = slope;
            for (size_t c = 0; c < 3; c++)
                p.patch.lens_radiance[(j * 3 + c) * AREA + i] =
                    dx * dx + dy * dy < 4.0f ? 50.0f : 0;
        }
    assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
    struct lens_aperture aperture;
    lens_aperture_init(&p.plan.camera, &aperture);
    double inside = 0.0, outside = 0.0, square = 0.0, count = 0.0;
    for (size_t i = 0; i < AREA; i++) {
        float u[2] = {((float)(i % LENS_SIDE) + 0.5f - at) / -slope,
                      ((float)(i / LENS_SIDE) + 0.5f - at) / -slope},
              left, right;
        const double value = (double)p.out[0][i];
        /* the lamp is seen from x through the point u with x + s u = at */
        lens_aperture_chord(&aperture, u[1], &left, &right);
        const bool in = fabsf(u[1]) <= 1.0f && u[0] >= left && u[0] <= right && right > left;
        const bool deep = in && u[0] > left + 0.3f && u[0] < right - 0.3f && right - left > 0.8f;
        inside += in ? value : 0.0;
        outside += in ? 0.0 : value;
        square += deep ? value * value : 0.0;
        count += deep ? 1.0 : 0.0;
    }
    const double all = inside + outside;
    assert_true(outside < 0.25 * all); /* lamp and cells are each 4 pixels wide, the triangle 26 */
    assert_true(count > 50.0);
    assert_true(all > 0.8 * 50.0 * 3.14159 * 4.0 && all < 1.2 * 50.0 * 3.14159 * 4.0);
    const double mean = 50.0 * 3.14159 * 4.0 / ((double)aperture.area * 225.0);
    assert_true(sqrt(square / count) < 1.25 * mean && sqrt(square / count) > 0.75 * mean);
    lens_picture_destroy(&p);
}

/* Nothing in focus shines beyond its edge, nor does what is behind shine through: no halo. */
TEST(edges_in_focus_have_no_halo)
{
    struct lens_picture p;
    struct lens_statistics statistics;
    lens_picture_create(LENS_FENCE, 3, 0, &p);
    for (size_t i = 0; i < AREA; i++)
        for (size_t j = 0; j < 9; j++) {
            const bool dark = i % LENS_SIDE < LENS_SIDE / 2;
            p.patch.lens_slope[j * AREA + i] = dark ? 0.1f : -6.0f;
            for (size_t c = 0; c < 3; c++)
                p.patch.lens_radiance[(j * 3 + c) * AREA + i] = dark ? 0.1f : 2.0f;
        }
    assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
    for (size_t i = 0; i < AREA; i++) {
        const float expected = i % LENS_SIDE < LENS_SIDE / 2 ? 0.1f : 2.0f;
        if (fabsf(p.out[0][i] - expected) > 1e-5f)
            fail_msg("column %zu is %g", i % LENS_SIDE, (double)p.out[0][i]);
    }
    lens_picture_destroy(&p);
}

/* The mirror image of a lamp lies elsewhere than the mirror, and may be in focus where that is not
 * quite: all samples of a pixel agree on it. What one sample alone has met is spread as ever. */
TEST(mirror_images_stay_sharp)
{
    const size_t lamp = (size_t)48 * LENS_SIDE + 48, stray = (size_t)20 * LENS_SIDE + 20;
    struct lens_picture p;
    struct lens_statistics statistics;
    lens_picture_create(LENS_FENCE, 3, 0, &p);
    for (size_t i = 0; i < AREA; i++)
        for (size_t j = 0; j < 9; j++) {
            const bool lit = i == lamp || (i == stray && j == 4);
            p.patch.lens_slope[j * AREA + i] = 1.3f;
            for (size_t c = 0; c < 3; c++)
                p.patch.lens_radiance[(j * 3 + c) * AREA + i] =
                    lit ? 30.0f - (float)j : 0.1f + 0.01f * (float)j;
        }
    assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), 0);
    const double image = (double)p.out[1][lamp], alone = (double)p.out[1][stray];
    print_message("an image of 26 is %.2f, a sample's share of 3 is %.2f\n", image, alone);
    assert_true(image > 0.8 * 26.0 && image < 26.5);
    assert_true(alone < 0.5 * 3.0);
    lens_picture_destroy(&p);
}

/* A bright fence before something dark in focus, or beyond it: some pixels' samples all meet the
 * fence, and what they hide counts all the same. */
static double fence_energy(uint32_t l, uint32_t seed, uint32_t filter, bool beyond)
{
    struct lens_picture p;
    struct lens_statistics statistics;
    lens_picture_create_seeded(LENS_FENCE, l, 0, seed, &p);
    for (size_t i = 0; i < l * l * AREA; i++) {
        const size_t sample = i / AREA, pixel = i % AREA;
        float *slope = &p.patch.lens_slope[i];
        const bool fence = *slope > 4.0f;
        if (!fence && !beyond) *slope = 0.1f;
        for (size_t c = 0; c < 3; c++)
            p.patch.lens_radiance[(3 * sample + c) * AREA + pixel] = fence ? 3.0f : 0.1f;
    }
    assert_int_equal(lens_run(&p, filter, &statistics), 0);
    double sum = 0.0;
    for (size_t i = 0; i < 3 * AREA; i++) sum += (double)p.out[0][i];
    lens_picture_destroy(&p);
    return sum;
}

TEST(silhouettes_keep_their_energy)
{
    static const double most[] = {0.02, 0.01, 0.005};
    for (int beyond = 0; beyond < 2; beyond++) {
        const double reference = fence_energy(16, 5, LENS_FILTER_NONE, beyond);
        for (uint32_t l = 1; l <= 3; l++) {
            double sum = 0.0;
            for (uint32_t seed = 1; seed <= 4; seed++)
                sum += fence_energy(l, seed, LENS_FILTER_SHEARED, beyond) / 4.0;
            print_message("%u samples before what is %s: energy %+.2f %%\n", l * l,
                          beyond ? "beyond the focus" : "in focus", 100 * (sum / reference - 1.0));
            assert_true(fabs(sum / reference - 1.0) < most[l - 1]);
        }
    }
}

TEST(refuses)
{
    struct lens_picture p;
    struct lens_statistics statistics;
    lens_picture_create(LENS_FENCE, 2, 0, &p);
    assert_int_equal(lens_run(&p, 3, &statistics), ERR_RANGE);
    p.plan.lens_filter = LENS_FILTER_SHEARED;
    const struct rect outside = {90, 90, 97, 96}, empty = {5, 5, 5, 6};
    assert_int_equal(lens_filter(&p.plan, &p.patch, outside, p.out, NULL, &statistics), ERR_RANGE);
    assert_int_equal(lens_filter(&p.plan, &p.patch, empty, p.out, NULL, &statistics), ERR_RANGE);
    float *slopes = p.patch.lens_slope;
    p.patch.lens_slope = NULL;
    assert_int_equal(lens_run(&p, LENS_FILTER_SHEARED, &statistics), ERR_RANGE);
    assert_int_equal(lens_run(&p, LENS_FILTER_NONE, &statistics), 0);
    p.patch.lens_slope = slopes;
    lens_picture_destroy(&p);
}

TEST(halos_hang_on_the_plan_alone)
{
    struct plan plan = {.lens_strata_per_axis = 3, .lens_filter = LENS_FILTER_NONE};
    assert_int_equal(lens_halo_px(&plan), 0);
    plan.lens_filter = LENS_FILTER_AXIS_ALIGNED;
    assert_int_equal(lens_halo_px(&plan), 16);
    plan.lens_filter = LENS_FILTER_SHEARED;
    assert_true(lens_halo_px(&plan) > 48 && lens_halo_px(&plan) < 80);
}
