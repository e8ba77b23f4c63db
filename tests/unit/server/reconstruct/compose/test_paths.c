/* The path tracer's picture: means of the sums so far, pixel by pixel. */
#include <math.h>
#include <string.h>

#include "proto/job/job.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

/* Draws every block that is ready; returns how many pixels no sample of which meets a surface. */
static uint64_t draw(const struct plan *plan, struct film *film, struct image *image)
{
    uint32_t block;
    uint64_t background = 0;
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        struct block_statistics statistics;
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(
            block_reconstruct(plan, patch, film_block_rect(film, block), image, &statistics), 0);
        patch_destroy(&patch);
        background += statistics.pixels_background;
        film_block_done(film, block);
    }
    return background;
}

static void land(struct film *film, const struct plan *plan, uint32_t tile, uint32_t pass)
{
    assert_int_equal(film_land(film, tile, pass, synthetic_pass(plan, tile, pass)), 0);
}

static void is_mean(const struct plan *plan, const struct image *image, const char *channel,
                    enum plane_id plane, uint32_t c, int32_t x, int32_t y, uint32_t passes)
{
    const float sum = synthetic_passes_sum(plan, plane, x, y, passes, c);
    assert_true(picture_at(image, channel, x, y) == sum / (float)plan_pass_spp(plan, passes));
}

static void check_pixel(const struct plan *plan, const struct image *image, int32_t x, int32_t y,
                        uint32_t passes)
{
    static const struct {
        const char *layer;
        enum plane_id plane;
    } layers[] = {{"", PLANE_PATH_RADIANCE},
                  {"direct.", PLANE_PATH_DIRECT},
                  {"indirect.", PLANE_PATH_INDIRECT},
                  {"emission.", PLANE_PATH_EMISSION},
                  {"albedo.", PLANE_PATH_ALBEDO},
                  {"diffuse_direct.", PLANE_PATH_DIFFUSE_DIRECT},
                  {"diffuse_indirect.", PLANE_PATH_DIFFUSE_INDIRECT}};
    const double n = plan_pass_spp(plan, passes);
    for (uint32_t c = 0; c < 3; c++) {
        char channel[32];
        for (size_t k = 0; k < sizeof layers / sizeof layers[0]; k++) {
            snprintf(channel, sizeof channel, "%s%c", layers[k].layer, "RGB"[c]);
            is_mean(plan, image, channel, layers[k].plane, c, x, y, passes);
        }
    }
    is_mean(plan, image, "A", PLANE_PATH_COVERAGE, 0, x, y, passes);
    is_mean(plan, image, "occlusion.O", PLANE_PATH_VISIBILITY, 0, x, y, passes);
    assert_true((double)picture_at(image, "samples.N", x, y) == n);
    assert_true(picture_at(image, "depth.Z", x, y) == synthetic_pixel(plan, x, y).depth);
    assert_true(picture_at(image, "id.I", x, y) == (float)synthetic_pixel(plan, x, y).id);
}

/* Tiles of one block stand at different passes; each pixel is divided by its own count. */
TEST(every_layer_is_the_mean_so_far)
{
    struct plan plan;
    struct film *film;
    struct image *image;
    synthetic_paths_plan(&plan, 40, 20, 16, 100);
    film = picture_film(&plan, block_side_px(&plan), 0);
    assert_int_equal(image_create(LAYERS_AVAILABLE, 40, 20, &image), 0);
    for (uint32_t t = 1; t < 6; t++) land(film, &plan, t, 0);
    land(film, &plan, 4, 1);
    land(film, &plan, 4, 2);
    assert_int_equal(draw(&plan, film, image), 0);
    assert_true(picture_at(image, "samples.N", 20, 18) == 0.0f);
    land(film, &plan, 0, 0);
    draw(&plan, film, image);
    for (int32_t y = 0; y < 20; y++)
        for (int32_t x = 0; x < 40; x++)
            check_pixel(&plan, image, x, y, x / 16 == 1 && y / 16 == 1 ? 3 : 1);
    for (uint32_t p = 1; p < 4; p++)
        for (uint32_t t = 0; t < 6; t++)
            if (t != 4 || p > 2) land(film, &plan, t, p);
    uint64_t background = draw(&plan, film, image), expected = 0;
    for (int32_t y = 0; y < 20; y++)
        for (int32_t x = 0; x < 40; x++) {
            check_pixel(&plan, image, x, y, 4);
            expected += picture_at(image, "A", x, y) == 0.0f;
        }
    assert_true(film_complete(film) && expected > 0);
    assert_int_equal(background, expected);
    image_destroy(&image);
    film_destroy(&film);
}

/* The layer of errors estimates how far pixels are from where they are going. */
TEST(the_error_is_what_it_says)
{
    struct plan plan;
    double squares = 0;
    unsigned count = 0;
    synthetic_paths_plan(&plan, 24, 24, 8, 64);
    for (int32_t y = 0; y < 24; y++)
        for (int32_t x = 0; x < 24; x++) {
            const double mean =
                (double)synthetic_passes_sum(&plan, PLANE_PATH_RADIANCE, x, y, 3, 0) / 64;
            const double truth =
                (double)synthetic_path_sum(PLANE_PATH_RADIANCE, x, y, 64, 4000, 0) / 4000;
            const double error = sqrt(synthetic_spread(x, y, 0, 64, 0) / (64.0 * 63.0));
            if (error == 0) continue;
            squares += (mean - truth) * (mean - truth) / (error * error);
            count++;
        }
    assert_true(count > 200);
    assert_true(fabs(squares / count - 1) < 0.2); /* 1 + 64/4000, and the noise of 400 pixels */
}

TEST(a_single_sample_has_no_error)
{
    struct plan plan;
    struct film *film;
    struct image *image;
    synthetic_paths_plan(&plan, 8, 8, 8, 1);
    assert_int_equal(film_create(&plan, block_side_px(&plan), 0, 0, &film), 0);
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_ERROR, 8, 8, &image), 0);
    land(film, &plan, 0, 0);
    draw(&plan, film, image);
    for (int32_t i = 0; i < 64; i++) {
        assert_true(picture_at(image, "error.G", i % 8, i / 8) == 0.0f);
        assert_true(picture_at(image, "G", i % 8, i / 8) ==
                    synthetic_path(PLANE_PATH_RADIANCE, i % 8, i / 8, 0, 1));
    }
    image_destroy(&image);
    film_destroy(&film);
}

/* Whatever a worker sends, the picture holds numbers. */
TEST(pictures_are_finite)
{
    struct plan plan;
    struct patch *patch;
    struct image *image;
    struct block_statistics statistics;
    const struct rect all = {0, 0, 4, 1};
    synthetic_paths_plan(&plan, 4, 1, 8, 64);
    assert_int_equal(patch_create(&plan, all, &patch), 0);
    assert_int_equal(image_create(LAYERS_AVAILABLE, 4, 1, &image), 0);
    for (int i = 0; i < 4; i++) {
        static const float hostile[] = {INFINITY, NAN, 3e38f, 1.0f};
        patch->paths.spp[i] = 16.0f;
        for (int c = 0; c < 3; c++) patch->path_radiance[c][i] = patch->path_m2[c][i] = hostile[i];
    }
    assert_int_equal(block_reconstruct(&plan, patch, all, image, &statistics), 0);
    for (int32_t x = 0; x < 4; x++) {
        assert_true(isfinite(picture_at(image, "R", x, 0)) && picture_at(image, "R", x, 0) >= 0.0f);
        assert_true(isfinite(picture_at(image, "error.B", x, 0)) &&
                    picture_at(image, "error.B", x, 0) >= 0.0f);
    }
    assert_true(picture_at(image, "R", 3, 0) == 1.0f / 16.0f);
    image_destroy(&image);
    patch_destroy(&patch);
}

/* A plan asks for the planes of its layers alone; the others stay as they were. */
TEST(absent_planes_leave_zeros)
{
    struct plan plan;
    struct film *film;
    struct image *image;
    synthetic_paths_plan(&plan, 8, 8, 8, 4);
    plan.planes &= ~(PLANE_BIT(PATH_M2) | PLANE_BIT(PATH_VISIBILITY) | PLANE_BIT(PATH_COVERAGE) |
                     PLANE_BIT(PATH_ALBEDO));
    plan.occlusion_distance = 0;
    assert_int_equal(film_create(&plan, block_side_px(&plan), 0, 0, &film), 0);
    assert_int_equal(image_create(LAYERS_AVAILABLE, 8, 8, &image), 0);
    land(film, &plan, 0, 0);
    assert_int_equal(draw(&plan, film, image), 0);
    assert_true(picture_at(image, "R", 3, 3) > 0.0f);
    assert_true(picture_at(image, "A", 3, 3) == 0.0f && picture_at(image, "error.R", 3, 3) == 0.0f);
    assert_true(picture_at(image, "occlusion.O", 3, 3) == 0.0f &&
                picture_at(image, "albedo.R", 3, 3) == 0.0f);
    image_destroy(&image);
    film_destroy(&film);
}

/* Blocks of any size, the whole way from tiles of samples to the picture. */
TEST(the_error_is_the_same_for_any_block)
{
    static const int32_t sides[] = {64, 128, 256};
    struct image *first = NULL;
    for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) {
        struct plan plan;
        struct film *film;
        struct image *image;
        synthetic_paths_plan(&plan, 150, 140, 32, 16);
        assert_int_equal(
            film_create(&plan, sides[k], block_core_px(&plan), block_halo_px(&plan), &film), 0);
        assert_int_equal(image_create(LAYER_BEAUTY | LAYER_ERROR, 150, 140, &image), 0);
        for (uint32_t t = 0; t < 25; t++) land(film, &plan, t, 0);
        draw(&plan, film, image);
        assert_true(film_complete(film) && picture_at(image, "error.G", 70, 70) > 0.0f);
        film_destroy(&film);
        if (!first) {
            first = image;
            continue;
        }
        assert_memory_equal(first->data, image->data,
                            image->channel_count * 150u * 140u * sizeof(float));
        image_destroy(&image);
    }
    image_destroy(&first);
}
