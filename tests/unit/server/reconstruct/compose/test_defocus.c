/* The picture of a plan with lens samples, as their plain average. */
#include <math.h>

#include "proto/half.h"
#include "proto/job/job.h"
#include "proto/samples.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/unit.h"

enum { WIDTH = 41, HEIGHT = 23, TILE = 16 };

static void lens_plan(struct plan *plan, uint32_t l)
{
    *plan = (struct plan){
        .width_px = WIDTH,
        .height_px = HEIGHT,
        .tile_px = TILE,
        .camera = {.type = CAMERA_PERSPECTIVE,
                   .right = {1, 0, 0},
                   .up = {0, 1, 0},
                   .forward = {0, 0, -1},
                   .half_width = 0.5f,
                   .half_height = 0.5f,
                   .aperture_radius = 0.1f,
                   .focus_distance = 4},
        .planes = PLANES_LENS | PLANE_BIT(DEPTH),
        .lens_strata_per_axis = l,
        .radiance_scale = 4,
        .length_unit = 1,
        .mu = 1,
    };
}

/* Quarters, so that halves hold them. */
static float radiance_at(int32_t x, int32_t y, uint32_t sample, uint32_t c)
{
    return 0.25f * (float)((x * 3 + y * 5 + (int32_t)(sample * 7 + c)) % 16);
}

static float slope_at(int32_t x, int32_t y, uint32_t sample)
{
    return 0.5f * (float)((x + y * 3 + (int32_t)sample * 5) % 9 - 4);
}

static float coverage_at(int32_t x, int32_t y)
{
    return (x + y) % 7 == 0 ? 0.0f : 0.75f;
}

static void put_pixel(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t at,
                      const void *ctx)
{
    (void)ctx;
    const uint32_t n = plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    samples_f32(s, PLANE_DEPTH, 0)[at] = 1.0f + (float)x;
    samples_u16(s, PLANE_LENS_COVERAGE, 0)[at] = half_from_float(coverage_at(x, y));
    for (uint32_t k = 0; k < n; k++) {
        samples_u16(s, PLANE_LENS_SLOPE, k)[at] = half_from_float(slope_at(x, y, k));
        for (uint32_t c = 0; c < 3; c++)
            samples_f32(s, PLANE_LENS_RADIANCE, k * 3 + c)[at] = radiance_at(x, y, k, c);
    }
}

TEST(pictures_are_averages)
{
    static const char *const names[] = {"R", "G", "B"};
    struct plan plan;
    struct image *image;
    struct block_statistics found = {0};
    uint64_t expected = 0;
    lens_plan(&plan, 3);
    struct film *film = picture_film(&plan, 16, 0);
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_SAMPLES | LAYER_DEPTH | LAYER_FILTER_WIDTH,
                                  WIDTH, HEIGHT, &image),
                     0);
    picture_land_pixels(&plan, film, put_pixel, NULL);
    picture_draw(&plan, film, image, &found);
    assert_true(found.lens.pixels_filtered == 0 && found.lens_cpu_us == 0);
    assert_true(film_complete(film) && film_bytes(film) == 0);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            for (uint32_t c = 0; c < 3; c++) {
                float sum = 0.0f;
                for (uint32_t k = 0; k < 9; k++) sum += radiance_at(x, y, k, c);
                assert_true(fabsf(picture_at(image, names[c], x, y) - sum / 9.0f) < 1e-6f);
            }
            assert_true(picture_at(image, "A", x, y) == coverage_at(x, y));
            assert_true(picture_at(image, "samples.N", x, y) == 9.0f);
            assert_true(picture_at(image, "filter_width.W", x, y) == 0.0f);
            assert_true(picture_at(image, "depth.Z", x, y) == 1.0f + (float)x);
            expected += coverage_at(x, y) > 0.0f ? 0 : 1;
        }
    assert_true(expected > 0 && found.pixels_background == expected);
    image_destroy(&image);
    film_destroy(&film);
}

/* Samples lie in the patch plane by plane, also far around the block. */
TEST(patches_hold_samples)
{
    struct plan plan;
    struct film *film;
    uint32_t block;
    lens_plan(&plan, 2);
    plan.lens_filter = LENS_FILTER_SHEARED;
    assert_int_equal(film_create(&plan, 16, 5, 5, &film), 0);
    picture_land_pixels(&plan, film, put_pixel, NULL);
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        assert_int_equal(film_gather(film, block, &patch), 0);
        const struct rect r = patch->rect;
        const size_t area = (size_t)rect_area(r);
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++) {
                const size_t i = patch_pixel(patch, x, y);
                for (uint32_t k = 0; k < 4; k++) {
                    assert_true(patch->lens_slope[k * area + i] == slope_at(x, y, k));
                    for (uint32_t c = 0; c < 3; c++)
                        assert_true(patch->lens_radiance[(k * 3 + c) * area + i] ==
                                    radiance_at(x, y, k, c));
                }
                assert_true(patch->lens_coverage[i] == coverage_at(x, y));
            }
        patch_destroy(&patch);
        film_block_done(film, block);
    }
    film_destroy(&film);
}

/* Sums of the brightest halves stay finite, and a plan without coverage has no alpha to write. */
TEST(bright_samples_stay_finite)
{
    struct plan plan;
    struct patch *patch;
    struct image *image;
    struct block_statistics statistics;
    const struct rect all = {0, 0, 4, 4};
    lens_plan(&plan, 4);
    plan.width_px = plan.height_px = 4;
    plan.planes = PLANE_BIT(LENS_RADIANCE);
    assert_int_equal(patch_create(&plan, all, &patch), 0);
    assert_null(patch->lens_slope);
    for (size_t i = 0; i < 16 * 16 * 3; i++) patch->lens_radiance[i] = 1e38f;
    assert_int_equal(image_create(LAYER_BEAUTY, 4, 4, &image), 0);
    assert_int_equal(block_reconstruct(&plan, patch, all, image, &statistics), 0);
    assert_true(isfinite(picture_at(image, "G", 2, 3)) && picture_at(image, "G", 2, 3) > 1e29f);
    assert_int_equal(statistics.pixels_background, 0);
    image_destroy(&image);
    patch_destroy(&patch);
}
