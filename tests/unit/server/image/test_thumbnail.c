/* Small pictures: their sides, their means, and files that are no pictures of ours. */
#include <png.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/image/png.h"
#include "server/image/thumbnail.h"
#include "server/image/tonemap.h"
#include "tests/unit/unit.h"

static struct image *make_image(int32_t width, int32_t height, float left, float right)
{
    static const char *const names[] = {"R", "G", "B"};
    struct image *image;
    assert_int_equal(image_create_named(names, 3, width, height, &image), 0);
    for (int c = 0; c < 3; c++)
        for (int32_t y = 0; y < height; y++)
            for (int32_t x = 0; x < width; x++)
                *plane_at(&image->channels[c].plane, x, y) = x < width / 2 ? left : right;
    return image;
}

static void check_sides(int32_t width, int32_t height, int32_t small_width, int32_t small_height)
{
    struct image *image = make_image(width, height, 0.25f, 0.25f), *small;
    assert_int_equal(thumbnail_of_image(image, &small), 0);
    assert_int_equal(small->width_px, small_width);
    assert_int_equal(small->height_px, small_height);
    for (int32_t y = 0; y < small_height; y++)
        for (int32_t x = 0; x < small_width; x++)
            assert_true(*plane_at(&small->channels[0].plane, x, y) == 0.25f);
    image_destroy(&small);
    image_destroy(&image);
}

TEST(sides_fit_and_are_never_enlarged)
{
    check_sides(720, 720, 160, 160);
    check_sides(640, 360, 160, 90);
    check_sides(161, 10, 160, 10);
    check_sides(16, 9, 16, 9);
    check_sides(1, 5000, 1, 160);
}

static void write_as(const struct image *image, const struct png_options *options, const char *path)
{
    uint8_t *data;
    size_t size_bytes;
    assert_int_equal(png_encode(image, "beauty", options, &data, &size_bytes), 0);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size_bytes, file), size_bytes);
    fclose(file);
    free(data);
}

static void write_png(const struct image *image, const char *path)
{
    const struct png_options options = {.view = VIEW_LINEAR};
    write_as(image, &options, path);
}

/* Decodes it; the caller frees. */
static uint8_t *decode(const uint8_t *data, size_t size_bytes, uint32_t *width, uint32_t *height)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_memory(&png, data, size_bytes));
    png.format = PNG_FORMAT_RGB;
    uint8_t *rgb = malloc(PNG_IMAGE_SIZE(png));
    assert_true(png_image_finish_read(&png, NULL, rgb, 0, NULL));
    *width = png.width;
    *height = png.height;
    return rgb;
}

static char path[64];

static int set_up(void **state)
{
    (void)state;
    strcpy(path, "/tmp/shearwater-thumbnail-XXXXXX");
    const int fd = mkstemp(path);
    return fd < 0 ? -1 : close(fd);
}

static int tear_down(void **state)
{
    (void)state;
    return unlink(path);
}

EACH_TEST(set_up, tear_down);

TEST(files_are_averaged_in_linear_light)
{
    uint32_t width, height;
    uint8_t *data;
    size_t size_bytes;
    struct image *image = make_image(500, 300, 0.0f, 1.0f);
    for (int c = 0; c < 3; c++) /* lines of one pixel: a mean of halves */
        for (int32_t y = 0; y < 300; y++)
            for (int32_t x = 250; x < 500; x++)
                *plane_at(&image->channels[c].plane, x, y) = (float)(y & 1);
    write_png(image, path);
    assert_int_equal(thumbnail_of_png(path, &data, &size_bytes), 0);
    uint8_t *rgb = decode(data, size_bytes, &width, &height);
    assert_int_equal(width, 160);
    assert_int_equal(height, 96);
    assert_int_equal(rgb[3 * 10], 0);
    double sum = 0.0;
    for (uint32_t y = 0; y < height; y++) sum += rgb[3 * (y * width + 120)];
    /* Half the light is byte 188, not 128; rows of 3 or 4 lines have a little more or less of it.
     */
    assert_true(sum / height > 184.0 && sum / height < 190.0);
    free(rgb);
    free(data);
    image_destroy(&image);
}

TEST(grey_stays_the_same_byte)
{
    for (int byte = 0; byte < 256; byte += 5) {
        uint32_t width, height;
        uint8_t *data;
        size_t size_bytes;
        float value = 0.0f;
        while (tonemap_byte(value, 1.0f) < byte) value += 1e-4f;
        struct image *image = make_image(200, 170, value, value);
        write_png(image, path);
        assert_int_equal(thumbnail_of_png(path, &data, &size_bytes), 0);
        uint8_t *rgb = decode(data, size_bytes, &width, &height);
        for (uint32_t i = 0; i < 3 * width * height; i++) assert_int_equal(rgb[i], byte);
        free(rgb);
        free(data);
        image_destroy(&image);
    }
}

/* Of 16 bits, and with alpha, whatever is transparent being black. */
TEST(pictures_of_all_kinds_are_read)
{
    static const char *const names[] = {"A", "B", "G", "R"};
    const struct png_options deep = {.view = VIEW_LINEAR, .is_deep = true};
    const struct png_options cut = {.view = VIEW_LINEAR, .is_deep = true, .alpha = true};
    struct image *image;
    assert_int_equal(image_create_named(names, 4, 200, 100, &image), 0);
    for (int c = 0; c < 4; c++)
        for (int32_t y = 0; y < 100; y++)
            for (int32_t x = 0; x < 200; x++)
                *plane_at(&image->channels[c].plane, x, y) = x < 100 ? 1.0f : 0.0f;
    for (int k = 0; k < 2; k++) {
        uint32_t width, height;
        uint8_t *data;
        size_t size_bytes;
        write_as(image, k ? &cut : &deep, path);
        assert_int_equal(thumbnail_of_png(path, &data, &size_bytes), 0);
        uint8_t *rgb = decode(data, size_bytes, &width, &height);
        assert_true(width == 160 && height == 80);
        assert_int_equal(rgb[0], 255);
        assert_int_equal(rgb[3 * 159], 0);
        free(rgb);
        free(data);
    }
    image_destroy(&image);
}

TEST(what_is_no_picture_is_refused)
{
    uint8_t *data;
    size_t size_bytes;
    struct image *image = make_image(300, 300, 0.1f, 0.9f);
    assert_int_equal(thumbnail_of_png(path, &data, &size_bytes), ERR_CORRUPT); /* empty */
    write_png(image, path);
    assert_int_equal(truncate(path, 200), 0);
    assert_int_equal(thumbnail_of_png(path, &data, &size_bytes), ERR_CORRUPT);
    assert_null(data);
    assert_int_equal(thumbnail_of_png("/tmp/shearwater-no-such", &data, &size_bytes), ERR_IO);
    image_destroy(&image);
}

TEST(an_image_without_beauty_has_none)
{
    static const char *const names[] = {"depth.Z"};
    struct image *image, *small;
    assert_int_equal(image_create_named(names, 1, 8, 8, &image), 0);
    assert_int_equal(thumbnail_of_image(image, &small), ERR_NOT_FOUND);
    image_destroy(&image);
}
