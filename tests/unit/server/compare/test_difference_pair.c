/* Errors beside two references: closed forms, noise that is taken out, what cannot be told. */
#include <stdlib.h>
#include <string.h>

#include <math.h>

#include "server/compare/difference_pair.h"
#include "tests/unit/unit.h"

static const char *const rgb[] = {"R", "G", "B"};

static struct image *filled(int32_t width, int32_t height, float value)
{
    struct image *image;
    assert_int_equal(image_create_named(rgb, 3, width, height, &image), 0);
    for (size_t i = 0; i < 3 * (size_t)width * (size_t)height; i++) image->data[i] = value;
    return image;
}

static struct image *a, *b, *x;

static void fill(int32_t width, int32_t height, float first, float second, float test)
{
    a = filled(width, height, first);
    b = filled(width, height, second);
    x = filled(width, height, test);
}

static int tear_down(void **state)
{
    (void)state;
    image_destroy(&a);
    image_destroy(&b);
    image_destroy(&x);
    return 0;
}

EACH_TEST(NULL, tear_down);

static struct difference_pair found(void)
{
    struct difference_pair d;
    assert_int_equal(difference_pair(a, b, x, "beauty", &d, NULL), 0);
    return d;
}

static bool near(double v, double wanted, double within)
{
    return fabs(v - wanted) <= within;
}

TEST(test_closed_forms)
{
    fill(20, 10, 0.5f, 0.25f, 0.75f);
    const struct difference_pair d = found();
    /* sRGB: 0.735357, 0.537099, 0.880825 */
    assert_true(near(d.psnr_db, -10 * log10((0.880825 - 0.735357) * (0.880825 - 0.537099)), 1e-4));
    assert_true(near(d.rmse01, sqrt(0.25 * 0.5), 1e-12));
    assert_true(near(d.relmse999, 0.25 * 0.5 / (0.375 * 0.375 + 0.01), 1e-12));
}

/* Two figures are of what a screen shows, the third of all. */
TEST(test_beyond_white)
{
    fill(4, 4, 2.0f, 2.0f, 3.0f);
    struct difference_pair d = found();
    assert_true(isnan(d.psnr_db) && isnan(d.rmse01));
    assert_true(near(d.relmse999, 1 / 4.01, 1e-12));
    for (int i = 0; i < 3; i++) x->data[16 * i] = 0.5f; /* one pixel of 16 */
    d = found();
    assert_true(near(d.psnr_db, -10 * log10(0.264643 * 0.264643 / 16), 1e-4));
    assert_true(near(d.rmse01, 0.125, 1e-12));
}

/* Of 2,000 pixels the largest two do not count, of 999 the largest; one alone does. */
TEST(test_the_worst_are_left_out)
{
    fill(50, 40, 0.0f, 0.0f, 0.1f);
    x->data[7] = x->data[1999] = 50.0f;
    assert_true(near(found().relmse999, 1, 1e-6));
    x->data[8] = 1.0f;
    assert_true(near(found().relmse999, 1 + 99 / 3.0 / 1998, 1e-6));
    tear_down(NULL);
    fill(27, 37, 0.0f, 0.0f, 0.1f);
    x->data[7] = 50.0f;
    assert_true(near(found().relmse999, 1, 1e-6));
    tear_down(NULL);
    fill(1, 1, 0.0f, 0.0f, 0.1f);
    assert_true(near(found().relmse999, 1, 1e-6));
}

/* In [-0.5, 0.5]. */
static float noise(uint32_t i)
{
    uint32_t h = i * 0x9e3779b9u + 12345u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)((h ^ h >> 15) >> 8) * 0x1p-24f - 0.5f;
}

/* References whose noise has a deviation of 0.02, which is the error everywhere: beside one of them
 * the mean square error is 8e-4, beside their mean 6e-4. */
TEST(test_the_references_noise_is_taken_out)
{
    fill(400, 300, 0.5f, 0.5f, 0.52f);
    const size_t values = (size_t)3 * 400 * 300;
    for (size_t i = 0; i < values; i++) {
        a->data[i] += 0.0693f * noise((uint32_t)i);
        b->data[i] += 0.0693f * noise((uint32_t)(i + values));
    }
    const struct difference_pair d = found();
    /* The mean of the products has a standard error of 1.2e-6. */
    assert_true(near(d.rmse01 * d.rmse01, 4e-4, 5e-6));
    assert_true(near(d.psnr_db, -20 * log10(0.748379 - 0.735357), 0.1));
    /* What it is divided by has noise of its own, which is worth 8 % here. */
    assert_true(near(d.relmse999 * 0.26, 4.3e-4, 1e-5));
}

TEST(test_what_noise_does_not_tell)
{
    fill(8, 8, 0.4f, 0.6f, 0.5f);
    struct difference_pair d = found();
    assert_true(isnan(d.psnr_db) && isnan(d.rmse01));
    assert_true(near(d.relmse999, -0.01 / 0.26, 1e-6));
    tear_down(NULL);
    fill(8, 8, 0.5f, 0.6f, 0.5f); /* the first reference itself */
    d = found();
    assert_true(isnan(d.psnr_db) && isnan(d.rmse01) && d.relmse999 == 0);
}

TEST(test_one_number_a_pixel)
{
    static const char *const depth[] = {"depth.Z"};
    struct difference_pair d;
    struct image **const all[] = {&a, &b, &x};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(image_create_named(depth, 1, 4, 4, all[i]), 0);
        for (int p = 0; p < 16; p++) (*all[i])->data[p] = 0.25f * (float)(i + 1);
    }
    assert_int_equal(difference_pair(a, b, x, "depth", &d, NULL), 0);
    assert_true(near(d.rmse01, sqrt(0.5 * 0.25), 1e-12));
    assert_true(near(d.relmse999, 0.125 / (0.375 * 0.375 + 0.01), 1e-12));
}

TEST(test_refusals)
{
    struct difference_pair d;
    struct fault fault;
    struct image *tall = filled(4, 5, 1), *mean;
    fill(4, 4, 0.1f, 0.2f, 0.3f);
    assert_int_equal(difference_pair(a, tall, x, "beauty", &d, &fault), ERR_MISMATCH);
    assert_string_equal(fault.detail, "sizes differ: 4 x 4 and 4 x 5");
    assert_int_equal(difference_pair(a, b, tall, "beauty", &d, &fault), ERR_MISMATCH);
    assert_int_equal(difference_pair_mean(a, tall, &mean, NULL), ERR_MISMATCH);
    assert_null(mean);
    image_destroy(&tall);
    assert_int_equal(difference_pair(a, b, x, "normal", &d, &fault), ERR_NOT_FOUND);
    assert_string_equal(fault.detail, "the first reference has no layer \"normal\"");
    *plane_at(image_plane(b, "G"), 2, 3) = NAN;
    assert_int_equal(difference_pair(a, b, x, "beauty", &d, &fault), ERR_NOT_FINITE);
    assert_string_equal(fault.detail,
                        "the second reference is not finite in layer \"beauty\" at pixel 2, 3");
    *plane_at(image_plane(b, "G"), 2, 3) = 0;
    *plane_at(image_plane(x, "B"), 1, 0) = INFINITY;
    assert_int_equal(difference_pair(a, b, x, "beauty", &d, &fault), ERR_NOT_FINITE);
    assert_string_equal(fault.detail,
                        "the test image is not finite in layer \"beauty\" at pixel 1, 0");
}

/* Channels that both have; errors as those of a mean of independent pictures. */
TEST(test_mean)
{
    static const char *const one[] = {"R", "error.R", "depth.Z"}, *const other[] = {"error.R", "R"};
    struct image *mean = NULL;
    assert_int_equal(image_create_named(one, 3, 2, 2, &a), 0);
    assert_int_equal(image_create_named(other, 2, 2, 2, &b), 0);
    *plane_at(image_plane(a, "R"), 1, 0) = 1;
    *plane_at(image_plane(b, "R"), 1, 0) = 2;
    *plane_at(image_plane(a, "error.R"), 0, 1) = 3;
    *plane_at(image_plane(b, "error.R"), 0, 1) = 4;
    assert_int_equal(difference_pair_mean(a, b, &mean, NULL), 0);
    assert_int_equal(mean->channel_count, 2);
    assert_true(*plane_at(image_plane(mean, "R"), 1, 0) == 1.5f);
    assert_true(*plane_at(image_plane(mean, "error.R"), 0, 1) == 2.5f);
    image_destroy(&mean);
    memcpy(b->channels[0].name, "x", 2);
    memcpy(b->channels[1].name, "y", 2);
    assert_int_equal(difference_pair_mean(a, b, &mean, NULL), ERR_NOT_FOUND);
    assert_null(mean);
}
