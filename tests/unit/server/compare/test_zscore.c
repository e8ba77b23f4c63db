/* z of noise whose size is known. */
#include "tests/unit/server/job/frame/picture_case.h"
#include "tests/unit/unit.h"

#include "server/compare/reduce.h"
#include "server/compare/zscore.h"

/* Adds noise of the picture's own standard error times `factor`. */
static void add_noise(struct image *image, double factor, uint64_t seed)
{
    for (uint32_t c = 0; c < 3; c++)
        for (int32_t y = 0; y < image->height_px; y++)
            for (int32_t x = 0; x < image->width_px; x++) {
                double se = (double)*plane_at(&image->channels[c + 3].plane, x, y);
                *plane_at(&image->channels[c].plane, x, y) +=
                    (float)(factor * se * picture_normal(&seed));
            }
}

static void expect_standard(const struct zscore *z, double spread)
{
    double n = (double)z->count;
    assert_true(fabs(z->mean) < 4 * spread / sqrt(n));
    assert_true(fabs(z->rms / spread - 1) < 4 / sqrt(2 * n));
    assert_true(fabs(z->median / spread - 0.6745) < 4 * 0.787 / sqrt(n));
    if (spread != 1) return;
    assert_true(fabs(z->beyond[0] - 0.0455) < 4 * sqrt(0.0455 / n));
    assert_true(fabs(z->beyond[1] - 0.0027) < 4 * sqrt(0.0027 / n));
    /* So rare that counts are Poisson's: four of its deviations, and one. */
    assert_true(z->beyond[2] * n < 0.0000633 * n + 4 * sqrt(0.0000633 * n) + 1);
}

TEST(test_true_errors_give_the_normal_distribution)
{
    struct image *r = picture_filled(128, 96, 2.0f, 0.0f);
    struct image *t = picture_filled(128, 96, 2.0f, 0.125f);
    struct image *small_r, *small_t;
    struct zscore z;
    add_noise(t, 1, 1);
    assert_int_equal(image_zscore(r, t, 2, &z, NULL), 0);
    assert_int_equal(z.count, 3 * 128 * 96);
    assert_int_equal(z.without, 0);
    expect_standard(&z, 1);
    assert_true(fabs(z.mean_error[1] - 0.125 / sqrt(128 * 96)) < 1e-9);
    assert_true(fabs(z.relmse - 0.125 * 0.125 / (4 + 0.01 * 4)) < 1e-9);
    assert_int_equal(image_reduce(r, image_rect(r), 3, &small_r, NULL), 0);
    assert_int_equal(image_reduce(t, image_rect(t), 3, &small_t, NULL), 0);
    assert_int_equal(image_zscore(small_r, small_t, 2, &z, NULL), 0);
    assert_int_equal(z.count, 3 * 42 * 32);
    expect_standard(&z, 1);
    image_destroy(&small_r);
    image_destroy(&small_t);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_wrong_errors_show)
{
    struct image *r = picture_filled(64, 64, 2.0f, 0.0f), *t = picture_filled(64, 64, 2.0f, 0.125f);
    struct zscore z;
    add_noise(t, 2, 5);
    assert_int_equal(image_zscore(r, t, 2, &z, NULL), 0);
    expect_standard(&z, 2);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_both_errors_count)
{
    struct image *r = picture_filled(64, 64, 2.0f, 0.375f), *t = picture_filled(64, 64, 2.0f, 0.5f);
    struct zscore z;
    add_noise(r, 1, 6);
    add_noise(t, 1, 7);
    assert_int_equal(image_zscore(r, t, 2, &z, NULL), 0);
    expect_standard(&z, 1);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_worst_and_left_out)
{
    struct image *r = picture_filled(8, 8, 1.0f, 0.0f), *t = picture_filled(8, 8, 1.0f, 0.5f);
    struct zscore z;
    *plane_at(image_plane(t, "G"), 5, 2) = -1.5f;
    *plane_at(image_plane(t, "B"), 1, 1) = NAN;
    *plane_at(image_plane(t, "error.R"), 0, 0) = 0.0f;
    assert_int_equal(image_zscore(r, t, 2, &z, NULL), 0);
    assert_int_equal(z.count, 3 * 64 - 2);
    assert_int_equal(z.without, 2);
    assert_true(z.worst == -5 && z.worst_x == 5 && z.worst_y == 2 && z.worst_channel == 1);
    assert_true(fabs(z.beyond[2] - 1.0 / 190) < 1e-12);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_refusals)
{
    struct image *r = picture_filled(4, 4, 1, 0), *t = picture_filled(4, 5, 1, 1);
    struct zscore z;
    struct fault fault;
    assert_int_equal(image_zscore(r, t, 2, &z, &fault), ERR_MISMATCH);
    assert_int_equal(image_zscore(r, r, 2, &z, &fault), ERR_NOT_FOUND);
    assert_string_equal(fault.detail, "the test image has no layer \"error\"");
    image_destroy(&r);
    image_destroy(&t);
}
