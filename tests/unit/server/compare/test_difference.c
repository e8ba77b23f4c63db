/* The figures of docs/accuracy.md on images whose figures are known. */
#include <math.h>

#include "server/compare/difference.h"
#include "tests/unit/unit.h"

static const char *const rgb[] = {"R", "G", "B"};

static struct image *filled(int32_t width, int32_t height, float value)
{
    struct image *image;
    assert_int_equal(image_create_named(rgb, 3, width, height, &image), 0);
    for (int c = 0; c < 3; c++)
        for (int32_t y = 0; y < height; y++)
            for (int32_t x = 0; x < width; x++) *plane_at(image_plane(image, rgb[c]), x, y) = value;
    return image;
}

TEST(test_constant_offset)
{
    struct image *r = filled(20, 10, 2.0f), *t = filled(20, 10, 2.5f);
    struct difference d;
    assert_int_equal(image_difference(r, t, "beauty", &d, NULL), 0);
    assert_true(fabs(d.rmse - 0.5) < 1e-12);
    assert_true(fabs(d.bias - 0.5) < 1e-12);
    assert_true(fabs(d.relmse - 0.25 / (4 + 0.01 * 4)) < 1e-12);
    assert_true(fabs(d.p999 - 0.5) < 1e-6 && fabs(d.max - 0.5) < 1e-6);
    assert_true(d.finite);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_outlier_and_not_finite)
{
    struct image *r = filled(100, 100, 1.0f), *t = filled(100, 100, 1.0f);
    struct difference d;
    *plane_at(image_plane(t, "G"), 3, 4) = 11.0f;
    assert_int_equal(image_difference(r, t, "beauty", &d, NULL), 0);
    assert_true(fabs(d.max - 10) < 1e-6);
    assert_true(d.p999 == 0); /* one of 30,000 */
    assert_true(fabs(d.rmse - sqrt(100.0 / 30000)) < 1e-9);
    *plane_at(image_plane(t, "B"), 0, 0) = NAN;
    assert_int_equal(image_difference(r, t, "beauty", &d, NULL), 0);
    assert_false(d.finite);
    assert_true(isfinite(d.rmse));
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_ratio_of_means)
{
    struct image *r = filled(8, 8, 2.0f), *t = filled(8, 8, 2.5f);
    struct difference d;
    for (int32_t y = 0; y < 8; y++)
        for (int32_t x = 0; x < 8; x++) *plane_at(image_plane(r, "B"), x, y) = 0.0f;
    assert_int_equal(image_difference(r, t, "beauty", &d, NULL), 0);
    assert_true(fabs(d.ratio[0] - 1.25) < 1e-12 && isnan(d.ratio[2]));
    assert_true(fabs(d.mean - 4.0 / 3) < 1e-12);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_where)
{
    static const char *const names[] = {"R", "G", "B", "visibility.V"};
    const struct difference_where penumbra = {"visibility", 0.02, 0.98};
    const struct difference_where nowhere = {"visibility", 0.6, 0.7}, colour = {"beauty", 0, 1};
    struct image *r, *t = filled(8, 8, 1.0f);
    struct difference d;
    assert_int_equal(image_create_named(names, 4, 8, 8, &r), 0);
    *plane_at(image_plane(r, "visibility.V"), 2, 3) = 0.5f;
    *plane_at(image_plane(r, "visibility.V"), 4, 3) = 0.02f; /* the ends do not count */
    *plane_at(image_plane(r, "G"), 2, 3) = 4.0f;
    *plane_at(image_plane(r, "G"), 5, 5) = 9.0f;
    assert_int_equal(image_difference_where(r, t, "beauty", &penumbra, &d, NULL), 0);
    assert_int_equal(d.pixels, 1);
    assert_true(fabs(d.rmse - sqrt((1 + 9 + 1) / 3.0)) < 1e-12);
    assert_true(fabs(d.mean - 4 / 3.0) < 1e-12 && fabs(d.max - 3) < 1e-12);
    assert_int_equal(image_difference_where(r, t, "beauty", &nowhere, &d, NULL), ERR_RANGE);
    assert_int_equal(image_difference_where(r, t, "beauty", &colour, &d, NULL), ERR_RANGE);
    assert_int_equal(image_difference_where(t, r, "beauty", &penumbra, &d, NULL), ERR_NOT_FOUND);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_refusals)
{
    struct image *r = filled(4, 4, 1), *t = filled(4, 5, 1);
    struct difference d;
    struct fault fault;
    assert_int_equal(image_difference(r, t, "beauty", &d, &fault), ERR_MISMATCH);
    assert_string_equal(fault.detail, "sizes differ: 4 x 4 and 4 x 5");
    assert_int_equal(image_difference(r, r, "normal", &d, &fault), ERR_NOT_FOUND);
    image_destroy(&r);
    image_destroy(&t);
}
