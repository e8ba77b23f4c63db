/* Light fields of pixel centres light lens samples. */
#include <math.h>
#include <stdlib.h>

#include "proto/job/job.h"
#include "server/reconstruct/lens/lens.h"
#include "server/reconstruct/lighting/lens_relight.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/lighting/lens_wall.h"
#include "tests/unit/unit.h"

static struct image *picture(const struct plan *plan, int32_t block_px,
                             struct lens_relight_statistics *sum)
{
    struct film *film = picture_film(plan, block_px, 0);
    struct image *image;
    struct block_statistics all = {0};
    assert_int_equal(image_create(LAYER_BEAUTY, SIDE, SIDE, &image), 0);
    wall_land(plan, film);
    picture_draw(plan, film, image, &all);
    *sum = all.lens_relight;
    film_destroy(&film);
    return image;
}

/* Far from the edge between the walls every sample shows what some pixel's centre does: the mean
 * of an even field is its value at the pixel, and what shines by itself is there, too. */
TEST(samples_take_light_from_where_the_middle_sees_their_point)
{
    static const float colors[] = {3, 2, 1}, albedo[] = {0.5f, 0.5f, 0.25f};
    static const char *const names[] = {"R", "G", "B"};
    struct lens_relight_statistics sum;
    struct plan plan;
    wall_plan(&plan, LENS_FILTER_NONE);
    struct image *image = picture(&plan, 64, &sum);
    for (int32_t y = 20; y < SIDE - 20; y++)
        for (int32_t x = 20; x < SIDE - 20; x++) {
            if (abs(x - SIDE / 2) < 24) continue;
            for (int c = 0; c < 3; c++) {
                const float own = c == 2 ? 0.125f : 0.0f;
                const float is = *plane_at(image_plane(image, names[c]), x, y);
                const float e = wall_irradiance((float)x + 0.5f, (float)y + 0.5f);
                const float should = own + e * colors[c] / 3.14159265f * albedo[c];
                /* points of the pixel and of the lens do not balance each other exactly */
                assert_true(fabsf(is - should) < 0.05f * should);
            }
        }
    image_destroy(&image);
}

/* The far wall's part that the near one hides from the middle, next to the edge: lit by the samples
 * themselves, which are much brighter here. Nothing else is, but for what lies outside the image.
 */
TEST(hidden_points_keep_their_own_light)
{
    struct lens_relight_statistics sum;
    struct plan plan;
    double hidden = 0.0, open = 0.0;
    wall_plan(&plan, LENS_FILTER_NONE);
    struct image *image = picture(&plan, 64, &sum);
    const struct plane *r = image_plane(image, "R");
    for (int32_t y = 20; y < SIDE - 20; y++) {
        for (int32_t x = SIDE / 2 - 6; x < SIDE / 2 + 6; x++) hidden += (double)*plane_at(r, x, y);
        for (int32_t x = 40; x < 52; x++) open += (double)*plane_at(r, x, y);
    }
    assert_true(hidden > 2.0 * open);
    assert_int_equal(sum.samples_lit + sum.samples_own, SIDE * SIDE * N);
    assert_true(sum.samples_own > 0 && sum.samples_own < SIDE * SIDE * N / 8);
    image_destroy(&image);
}

/* No pixel depends on how the image is cut, though light is found for a part around each alone. */
TEST(blocks_do_not_show)
{
    static const uint32_t filters[] = {LENS_FILTER_NONE, LENS_FILTER_AXIS_ALIGNED,
                                       LENS_FILTER_SHEARED};
    static const float apertures[] = {0.18f, 0.47f, 0.1f, 0.05f}; /* slopes of 1.2 to almost 24 */
    static const char *const names[] = {"R", "G", "B"};
    struct lens_relight_statistics small, large;
    struct plan plan;
    for (size_t k = 0; k < 4 * sizeof filters / sizeof filters[0]; k++) {
        if (filters[k / 4] != LENS_FILTER_SHEARED && k % 2) continue; /* they read no farther */
        wall_plan(&plan, filters[k / 4]);
        plan.camera.aperture_radius = apertures[k % 4];
        wall_noise = true; /* hidden points share what they have found */
        struct image *a = picture(&plan, 64, &small), *b = picture(&plan, SIDE, &large);
        wall_noise = false;
        for (int32_t y = 0; y < SIDE; y++)
            for (int32_t x = 0; x < SIDE; x++)
                for (int c = 0; c < 3; c++) {
                    const float p = *plane_at(image_plane(a, names[c]), x, y);
                    const float q = *plane_at(image_plane(b, names[c]), x, y);
                    if (!(p == q))
                        fail_msg("filter %zu, (%d, %d): %.9g and %.9g", k, x, y, (double)p,
                                 (double)q);
                }
        assert_int_equal(small.samples_lit, large.samples_lit);
        assert_int_equal(small.samples_own, large.samples_own);
        image_destroy(&a);
        image_destroy(&b);
    }
}

/* Who needs a second set is told by samples as they are lit: what comes of their paths alone is the
 * same everywhere here, and only hidden points are brighter than what is around them. */
TEST(second_sets_go_where_lit_samples_differ)
{
    static uint8_t levels[SIDE * SIDE];
    struct block_statistics statistics;
    struct plan plan;
    struct patch *patch;
    struct image *image;
    uint32_t block;
    int32_t hidden = 0, open = 0;
    wall_plan(&plan, LENS_FILTER_SHEARED);
    plan.planes |= PLANE_BIT(LENS_SECOND_SET);
    plan.lens_extra = 9;
    struct film *film = picture_film(&plan, SIDE, 0);
    assert_int_equal(image_create(LAYER_BEAUTY, SIDE, SIDE, &image), 0);
    wall_land(&plan, film);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    patch->lens_levels = levels;
    assert_int_equal(
        block_reconstruct(&plan, patch, film_block_rect(film, block), image, &statistics), 0);
    for (int32_t y = 20; y < SIDE - 20; y++)
        for (int32_t x = 40; x < SIDE / 2 + 6; x++) {
            const int32_t level = levels[y * SIDE + x];
            if (x < 52 && level > open) open = level;
            if (x >= SIDE / 2 - 6 && level > hidden) hidden = level;
        }
    assert_true(open > 0 && hidden > open + 8);
    patch_destroy(&patch);
    film_block_done(film, block);
    film_destroy(&film);
    image_destroy(&image);
}

/* Plans whose fields light none read no more than before. */
TEST(others_have_no_ring)
{
    struct plan plan;
    wall_plan(&plan, LENS_FILTER_SHEARED);
    assert_true(lens_relight_ring_px(&plan) > 24);
    plan.lens_relight = LENS_RELIGHT_OWN;
    plan.planes &= ~PLANES_LENS_SURFACE;
    assert_int_equal(lens_relight_ring_px(&plan), 0);
    assert_int_equal(block_halo_px(&plan), lens_halo_px(&plan));
}
