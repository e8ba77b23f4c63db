/* PNG files: what libpng reads back. */
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "server/image/png.h"
#include "server/image/tonemap.h"
#include "tests/unit/unit.h"

struct picture {
    uint32_t width, height;
    uint8_t *rgb; /* owned */
};

static struct picture decode(const uint8_t *data, size_t size_bytes)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    struct picture p = {0};
    assert_true(png_image_begin_read_from_memory(&png, data, size_bytes));
    assert_int_equal(png.flags & PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB, 0);
    png.format = PNG_FORMAT_RGB;
    p.width = png.width;
    p.height = png.height;
    p.rgb = malloc(PNG_IMAGE_SIZE(png));
    assert_true(png_image_finish_read(&png, NULL, p.rgb, 0, NULL));
    return p;
}

static struct image *make_image(const char *const *names, uint32_t count, int32_t w, int32_t h)
{
    struct image *image;
    assert_int_equal(image_create_named(names, count, w, h, &image), 0);
    for (uint32_t c = 0; c < count; c++) {
        for (int32_t y = 0; y < h; y++) {
            for (int32_t x = 0; x < w; x++) {
                *plane_at(&image->channels[c].plane, x, y) =
                    (float)(x + y * w) / (float)(w * h) * (1.0f + (float)c) - 0.1f;
            }
        }
    }
    return image;
}

static struct picture encode(const struct image *image, const char *layer, float exposure)
{
    uint8_t *data;
    size_t size_bytes;
    const struct png_options options = {.exposure_ev = exposure};
    assert_int_equal(png_encode(image, layer, &options, &data, &size_bytes), 0);
    struct picture p = decode(data, size_bytes);
    assert_int_equal(p.width, image->width_px);
    assert_int_equal(p.height, image->height_px);
    free(data);
    return p;
}

static const char *const beauty[] = {"R", "G", "B", "A"};

TEST(radiance_is_exposed_and_encoded)
{
    static const float exposures[] = {0.0f, -2.0f, 3.5f, 1000.0f, -1000.0f};
    struct image *image = make_image(beauty, 4, 37, 21);
    *plane_at(&image->channels[1].plane, 3, 3) = NAN;
    *plane_at(&image->channels[2].plane, 3, 3) = INFINITY;
    for (size_t n = 0; n < sizeof exposures / sizeof exposures[0]; n++) {
        float scale = exp2f(fminf(fmaxf(exposures[n], -126.0f), 126.0f));
        struct picture p = encode(image, "beauty", exposures[n]);
        for (int32_t y = 0; y < 21; y++) {
            for (int32_t x = 0; x < 37; x++) {
                for (int32_t c = 0; c < 3; c++) {
                    float v = *plane_at(&image->channels[c].plane, x, y);
                    assert_int_equal(p.rgb[(y * 37 + x) * 3 + c], tonemap_byte(v, scale));
                }
            }
        }
        free(p.rgb);
    }
    image_destroy(&image);
}

TEST(normals_and_scalars_are_shown_linearly)
{
    static const char *const names[] = {"normal.X", "normal.Y", "normal.Z", "depth.Z",
                                        "visibility.V"};
    struct image *image = make_image(names, 5, 2, 1);
    float values[5][2] = {{-1, 1}, {0, 0.5f}, {1, -2}, {4, 8}, {0.25f, 0.5f}};
    for (int c = 0; c < 5; c++) memcpy(image->channels[c].plane.data, values[c], sizeof values[c]);
    struct picture p = encode(image, "normal", 5.0f);
    static const uint8_t normals[] = {0, 128, 255, 255, 191, 0};
    assert_memory_equal(p.rgb, normals, 6);
    free(p.rgb);
    p = encode(image, "depth", 0.0f);
    static const uint8_t depths[] = {128, 128, 128, 255, 255, 255};
    assert_memory_equal(p.rgb, depths, 6);
    free(p.rgb);
    p = encode(image, "visibility", 0.0f); /* a share already: not stretched */
    static const uint8_t shares[] = {64, 64, 64, 128, 128, 128};
    assert_memory_equal(p.rgb, shares, 6);
    free(p.rgb);
    memset(image->channels[3].plane.data, 0, 2 * sizeof(float));
    p = encode(image, "depth", 0.0f);
    assert_int_equal(p.rgb[0], 0);
    free(p.rgb);
    image_destroy(&image);
}

TEST(a_layer_that_is_not_there_is_refused)
{
    uint8_t *data;
    size_t size_bytes;
    const struct png_options plain = {0};
    struct image *image = make_image(beauty, 4, 3, 3);
    assert_int_equal(png_encode(image, "albedo", &plain, &data, &size_bytes), ERR_NOT_FOUND);
    assert_null(data);
    image_destroy(&image);
}

TEST(equal_pictures_are_equal_bytes)
{
    uint8_t *a, *b;
    size_t a_bytes, b_bytes;
    const struct png_options half = {.exposure_ev = 0.5f, .view = VIEW_AGX, .is_deep = true};
    struct image *image = make_image(beauty, 4, 300, 200);
    assert_int_equal(png_encode(image, "beauty", &half, &a, &a_bytes), 0);
    assert_int_equal(png_encode(image, "beauty", &half, &b, &b_bytes), 0);
    assert_int_equal(a_bytes, b_bytes);
    assert_memory_equal(a, b, a_bytes);
    free(a);
    free(b);
    image_destroy(&image);
}

/* Also of what waits for the last row: a layer that is scaled by its largest value, which is there,
 * and a picture with alpha. */
TEST(rows_from_the_top_are_the_same_bytes)
{
    static const char *const depth[] = {"depth.Z"};
    const struct png_options all[] = {{.exposure_ev = 0.5f},
                                      {.exposure_ev = 0.5f},
                                      {.view = VIEW_FILMIC, .alpha = true, .is_deep = true}};
    for (int k = 0; k < 3; k++) {
        const bool scaled = k == 1;
        struct image *image = make_image(scaled ? depth : beauty, scaled ? 1 : 4, 30, 20);
        struct image *forming = make_image(scaled ? depth : beauty, scaled ? 1 : 4, 30, 20);
        const char *layer = scaled ? "depth" : "beauty";
        struct png_rows *rows;
        uint8_t *a, *b;
        size_t a_bytes, b_bytes;
        assert_int_equal(png_encode(image, layer, &all[k], &a, &a_bytes), 0);
        memset(forming->data, 0, sizeof(float) * 30 * 20 * image->channel_count);
        assert_int_equal(png_rows_begin(forming, layer, &all[k], &rows), 0);
        for (int32_t end = 0; end <= 20; end += 4) {
            for (uint32_t c = 0; c < image->channel_count; c++)
                memcpy(forming->channels[c].plane.data, image->channels[c].plane.data,
                       sizeof(float) * 30 * (size_t)end);
            assert_int_equal(png_rows_write(rows, end), 0);
        }
        assert_int_equal(png_rows_finish(&rows, &b, &b_bytes), 0);
        assert_int_equal(a_bytes, b_bytes);
        assert_memory_equal(a, b, a_bytes);
        free(a);
        free(b);
        image_destroy(&forming);
        image_destroy(&image);
    }
}
