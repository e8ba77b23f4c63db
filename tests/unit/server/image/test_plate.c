/* Plates: photographs as large as the picture. */
#include <stdlib.h>

#include "server/image/plate.h"
#include "tests/unit/unit.h"

static float *texels_of(int32_t across, int32_t down)
{
    float *texels = malloc((size_t)across * (size_t)down * 3 * sizeof *texels);
    assert_non_null(texels);
    for (int32_t i = 0; i < across * down; i++)
        for (int c = 0; c < 3; c++) texels[3 * i + c] = (float)(i + 1) * 0x1.1p-4f + (float)c;
    return texels;
}

static struct plate *plate_of(const float *texels, int32_t across, int32_t down, int32_t width,
                              int32_t height, enum plate_scaling scaling)
{
    struct plate *plate;
    assert_int_equal(plate_create(texels, across, down, width, height, scaling, &plate), 0);
    assert_int_equal(plate_image(plate)->width_px, width);
    assert_int_equal(plate_image(plate)->height_px, height);
    return plate;
}

static float at(const struct plate *plate, int c, int32_t x, int32_t y)
{
    return *plane_at(&plate_image(plate)->channels[c].plane, x, y);
}

TEST(one_of_the_pictures_size_keeps_its_bits)
{
    float *texels = texels_of(7, 5);
    for (int s = 0; s < 2; s++) {
        struct plate *plate = plate_of(texels, 7, 5, 7, 5, (enum plate_scaling)s);
        for (int32_t i = 0; i < 35; i++)
            for (int c = 0; c < 3; c++)
                assert_true(at(plate, c, i % 7, i / 7) == texels[3 * i + c]);
        plate_drop(&plate);
        assert_null(plate);
    }
    free(texels);
}

TEST(a_larger_one_is_averaged_by_area)
{
    float *texels = texels_of(6, 2);
    struct plate *plate = plate_of(texels, 6, 2, 2, 1, PLATE_STRETCH);
    for (int32_t x = 0; x < 2; x++) {
        float mean = 0;
        for (int32_t k = 0; k < 6; k++) mean += texels[3 * (3 * x + k % 3 + 6 * (k / 3))] / 6;
        assert_float_equal(at(plate, 0, x, 0), mean, 1e-6f);
    }
    plate_drop(&plate);
    free(texels);
}

TEST(a_wider_one_is_cut_on_both_sides)
{
    float *texels = texels_of(8, 2);
    struct plate *plate = plate_of(texels, 8, 2, 4, 2, PLATE_COVER);
    for (int32_t x = 0; x < 4; x++)
        assert_float_equal(at(plate, 1, x, 1), texels[3 * (8 + 2 + x) + 1], 1e-6f);
    plate_drop(&plate);
    free(texels);
}

TEST(a_smaller_one_is_interpolated)
{
    const float texels[] = {0, 0, 0, 1, 1, 1};
    struct plate *plate = plate_of(texels, 2, 1, 8, 1, PLATE_STRETCH);
    for (int32_t x = 1; x < 8; x++) assert_true(at(plate, 0, x, 0) >= at(plate, 0, x - 1, 0));
    assert_true(at(plate, 0, 0, 0) == 0.0f && at(plate, 0, 7, 0) == 1.0f);
    assert_float_equal(at(plate, 0, 3, 0) + at(plate, 0, 4, 0), 1.0f, 1e-6f);
    plate_drop(&plate);
}

TEST(the_last_reference_frees_it)
{
    float *texels = texels_of(1, 1);
    struct plate *plate = plate_of(texels, 1, 1, 3, 3, PLATE_COVER), *held = plate_hold(plate);
    plate_drop(&plate);
    assert_true(at(held, 2, 2, 2) == texels[2]);
    plate_drop(&held);
    plate_drop(&held); /* NULL */
    assert_null(plate_hold(NULL));
    free(texels);
}
