/* Averages of pictures over squares. */
#include "tests/unit/server/job/frame/picture_case.h"
#include "tests/unit/unit.h"

#include "server/compare/reduce.h"

TEST(test_means_and_errors_of_means)
{
    struct image *from = picture_filled(7, 5, 0.0f, 0.25f), *to;
    for (int32_t y = 0; y < 5; y++)
        for (int32_t x = 0; x < 7; x++)
            *plane_at(image_plane(from, "G"), x, y) = (float)(10 * y + x);
    assert_int_equal(image_reduce(from, image_rect(from), 2, &to, NULL), 0);
    assert_int_equal(to->width_px, 3);
    assert_int_equal(to->height_px, 2);
    assert_true(*plane_at(image_plane(to, "G"), 0, 0) == (0 + 1 + 10 + 11) / 4.0f);
    assert_true(*plane_at(image_plane(to, "G"), 2, 1) == (24 + 25 + 34 + 35) / 4.0f);
    assert_true(*plane_at(image_plane(to, "error.B"), 1, 1) == 0.125f); /* 0.25 / sqrt(4) */
    image_destroy(&to);
    image_destroy(&from);
}

TEST(test_crop)
{
    struct image *from = picture_filled(7, 5, 1.0f, 0.0f), *to;
    *plane_at(image_plane(from, "R"), 3, 4) = NAN;
    assert_int_equal(image_reduce(from, (struct rect){2, 1, 6, 5}, 2, &to, NULL), 0);
    assert_int_equal(to->width_px, 2);
    assert_int_equal(to->height_px, 2);
    assert_true(isnan(*plane_at(image_plane(to, "R"), 0, 1)));
    assert_true(*plane_at(image_plane(to, "R"), 1, 1) == 1.0f);
    image_destroy(&to);
    image_destroy(&from);
}

TEST(test_refusals)
{
    static const struct rect wrong[] = {
        {-1, 0, 4, 4}, {0, 0, 8, 4}, {0, 0, 4, 6}, {4, 0, 4, 4}, {0, 3, 4, 2}};
    struct image *from = picture_filled(7, 5, 1.0f, 0.0f), *to;
    struct fault fault;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_int_equal(image_reduce(from, wrong[i], 1, &to, &fault), ERR_RANGE);
    assert_int_equal(image_reduce(from, image_rect(from), 6, &to, &fault), ERR_RANGE);
    assert_string_equal(fault.detail, "a box of 6 pixels does not fit 7 x 5");
    assert_int_equal(image_reduce(from, image_rect(from), 0, &to, &fault), ERR_RANGE);
    assert_null(to);
    image_destroy(&from);
}
