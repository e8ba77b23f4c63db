/* Colours of the difference picture. */
#include "tests/unit/server/job/frame/picture_case.h"
#include "tests/unit/unit.h"

#include "server/compare/difference_picture.h"

static float red(const struct image *image, int32_t x, int32_t y)
{
    return *plane_at(image_plane(image, "R"), x, y);
}

static float blue(const struct image *image, int32_t x, int32_t y)
{
    return *plane_at(image_plane(image, "B"), x, y);
}

TEST(test_signs_and_legend)
{
    struct image *r = picture_filled(6, 4, 1.0f, 0.0f), *t = picture_filled(6, 4, 1.0f, 0.0f);
    struct image *p;
    for (int c = 0; c < 3; c++) {
        *plane_at(&t->channels[c].plane, 1, 0) = 1.05f;
        *plane_at(&t->channels[c].plane, 2, 0) = 0.95f;
        *plane_at(&t->channels[c].plane, 3, 0) = 100.0f;
        *plane_at(&t->channels[c].plane, 4, 0) = NAN;
    }
    assert_int_equal(difference_picture(r, t, "beauty", 0.1, 3, &p, NULL), 0);
    assert_int_equal(p->width_px, 18);
    assert_int_equal(p->height_px, 12 + DIFFERENCE_LEGEND_PX);
    assert_true(red(p, 0, 0) == 1.0f && blue(p, 2, 2) == 1.0f);             /* equal: white */
    assert_true(red(p, 3, 0) > blue(p, 3, 0) && blue(p, 3, 0) > 0.1f);      /* half-way to red */
    assert_true(blue(p, 8, 2) > red(p, 8, 2) && red(p, 8, 2) > 0.1f);       /* to blue */
    assert_true(red(p, 9, 0) > 5 * blue(p, 9, 0) && blue(p, 9, 0) < 0.02f); /* saturated */
    assert_true(red(p, 12, 0) == 1.0f && blue(p, 12, 0) == 0.0f);           /* yellow */
    assert_true(blue(p, 0, 20) > red(p, 0, 20) && red(p, 17, 20) > blue(p, 17, 20));
    assert_true(red(p, 8, 12) == 0.0f); /* the line above the legend */
    image_destroy(&p);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_one_pixel_and_scalars)
{
    static const char *const names[] = {"depth.Z"};
    struct image *r, *t, *p;
    assert_int_equal(image_create_named(names, 1, 1, 1, &r), 0);
    assert_int_equal(image_create_named(names, 1, 1, 1, &t), 0);
    *plane_at(&r->channels[0].plane, 0, 0) = 2.0f;
    *plane_at(&t->channels[0].plane, 0, 0) = 2.2f;
    assert_int_equal(difference_picture(r, t, "depth", 0.1, 1, &p, NULL), 0);
    assert_true(red(p, 0, 0) > blue(p, 0, 0));
    image_destroy(&p);
    image_destroy(&r);
    image_destroy(&t);
}

TEST(test_refusals)
{
    struct image *r = picture_filled(4, 4, 1, 0), *t = picture_filled(4, 5, 1, 0), *p;
    assert_int_equal(difference_picture(r, t, "beauty", 0.1, 1, &p, NULL), ERR_MISMATCH);
    assert_int_equal(difference_picture(r, r, "normal", 0.1, 1, &p, NULL), ERR_NOT_FOUND);
    assert_int_equal(difference_picture(r, r, "beauty", 0, 1, &p, NULL), ERR_RANGE);
    assert_int_equal(difference_picture(r, r, "beauty", 0.1, 0, &p, NULL), ERR_RANGE);
    assert_int_equal(difference_picture(r, r, "beauty", 0.1, 1 << 29, &p, NULL), ERR_LIMIT);
    assert_null(p);
    image_destroy(&r);
    image_destroy(&t);
}
