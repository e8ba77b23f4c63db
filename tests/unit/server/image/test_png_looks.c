/* Looks of PNG files: views, 16 bits, alpha and chunks, as libpng reads them back. */
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "server/image/png.h"
#include "tests/unit/unit.h"

/* A file without any conversion by the reader. */
struct raw {
    int bits, color_type, intent;
    bool has_srgb, has_gamma;
    int channels;
    uint16_t samples[4 * 64];
};

struct source {
    const uint8_t *data;
    size_t left;
};

static void read_bytes(png_structp png, png_bytep out, size_t size_bytes)
{
    struct source *source = png_get_io_ptr(png);
    assert_true(size_bytes <= source->left);
    memcpy(out, source->data, size_bytes);
    source->data += size_bytes;
    source->left -= size_bytes;
}

static struct raw decode(const uint8_t *data, size_t size_bytes)
{
    struct raw raw = {0};
    struct source source = {data, size_bytes};
    double gamma;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    assert_int_equal(setjmp(png_jmpbuf(png)), 0);
    png_set_read_fn(png, &source, read_bytes);
    png_read_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    raw.bits = png_get_bit_depth(png, info);
    raw.color_type = png_get_color_type(png, info);
    raw.channels = png_get_channels(png, info);
    raw.has_srgb = png_get_sRGB(png, info, &raw.intent) != 0;
    raw.has_gamma = png_get_gAMA(png, info, &gamma) != 0;
    png_bytepp rows = png_get_rows(png, info);
    const size_t count = (size_t)raw.channels * png_get_image_width(png, info);
    assert_int_equal(png_get_image_height(png, info), 1);
    assert_true(count <= sizeof raw.samples / sizeof raw.samples[0]);
    for (size_t i = 0; i < count; i++)
        raw.samples[i] =
            raw.bits == 16 ? (uint16_t)(rows[0][2 * i] << 8 | rows[0][2 * i + 1]) : rows[0][i];
    png_destroy_read_struct(&png, &info, NULL);
    return raw;
}

static struct raw encode(const struct image *image, const char *layer, struct png_options options)
{
    uint8_t *data;
    size_t size_bytes;
    assert_int_equal(png_encode(image, layer, &options, &data, &size_bytes), 0);
    const struct raw raw = decode(data, size_bytes);
    free(data);
    return raw;
}

/* One row of pixels with four channels each. */
static struct image *make_row(const char *const names[4], const float (*pixels)[4], int32_t count)
{
    struct image *image;
    assert_int_equal(image_create_named(names, 4, count, 1, &image), 0);
    for (int32_t x = 0; x < count; x++)
        for (int c = 0; c < 4; c++) *plane_at(&image->channels[c].plane, x, 0) = pixels[x][c];
    return image;
}

static const char *const beauty[4] = {"R", "G", "B", "A"};

/* IEC 61966-2-1, in double precision. */
static double srgb(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

TEST(a_view_shows_light_and_nothing_else)
{
    static const char *const albedo[4] = {"albedo.R", "albedo.G", "albedo.B", "depth.Z"};
    static const float pixels[][4] = {{0.18f, 0.4f, 3.0f, 1}, {0.01f, 0.8f, 0.2f, 1}};
    struct image *image = make_row(beauty, pixels, 2), *data = make_row(albedo, pixels, 2);
    for (enum view_curve curve = VIEW_LINEAR; curve <= VIEW_AGX; curve++) {
        const struct png_options options = {.view = curve, .exposure_ev = 1};
        const struct view_transform view = view_transform_of(curve, 1);
        const struct raw light = encode(image, "beauty", options);
        const struct raw plain = encode(data, "albedo", options);
        for (int x = 0; x < 2; x++) {
            const double in[3] = {(double)pixels[x][0], (double)pixels[x][1], (double)pixels[x][2]};
            struct view_pixels shown = {{{in[0]}, {in[1]}, {in[2]}}};
            view_transform_apply(&view, &shown);
            for (int c = 0; c < 3; c++) {
                const double v = shown.channel[c][0];
                assert_int_equal(light.samples[3 * x + c], lrint(255 * srgb(v)));
                assert_int_equal(plain.samples[3 * x + c], lrint(255 * srgb(fmin(2 * in[c], 1))));
            }
        }
        assert_memory_equal(encode(data, "depth", options).samples,
                            encode(data, "depth", (struct png_options){0}).samples, 12);
    }
    const struct png_options bright = {.view = VIEW_AGX, .exposure_ev = 3, .is_deep = true};
    assert_true(png_options_of_layer(&bright, "albedo").exposure_ev == 0.0f);
    assert_true(png_options_of_layer(&bright, "direct").exposure_ev == 3.0f);
    image_destroy(&image);
    image_destroy(&data);
}

TEST(sixteen_bits_tell_neighbours_apart)
{
    static const float pixels[][4] = {
        {0, 1, 0.5f, 1}, {0.5001f, 1e-4f, 2, 1}, {NAN, -1, INFINITY, 1}};
    struct image *image = make_row(beauty, pixels, 3);
    const struct raw raw = encode(image, "beauty", (struct png_options){.is_deep = true});
    assert_int_equal(raw.bits, 16);
    assert_int_equal(raw.color_type, PNG_COLOR_TYPE_RGB);
    assert_true(raw.has_srgb && raw.has_gamma && raw.intent == PNG_sRGB_INTENT_PERCEPTUAL);
    static const double shown[9] = {0, 1, 0.5, 0.5001f, 1e-4f, 1, 0, 0, 1};
    for (int i = 0; i < 9; i++) assert_true(fabs(raw.samples[i] - 65535 * srgb(shown[i])) <= 0.6);
    assert_true(raw.samples[3] > raw.samples[2]); /* the same byte */
    image_destroy(&image);
}

/* What PNG wants: the colour of what covers the pixel, whatever its share. */
TEST(alpha_is_straight)
{
    static const float pixels[][4] = {
        {0.4f, 0.2f, 0.1f, 1}, {0.1f, 0.05f, 0.025f, 0.25f}, {0, 0, 0, 0}, {0, 0, 0, NAN}};
    struct image *image = make_row(beauty, pixels, 4);
    for (enum view_curve curve = VIEW_LINEAR; curve <= VIEW_AGX; curve++) {
        const struct raw raw =
            encode(image, "beauty", (struct png_options){.alpha = true, .view = curve});
        assert_int_equal(raw.color_type, PNG_COLOR_TYPE_RGB_ALPHA);
        for (int c = 0; c < 3; c++) {
            assert_int_equal(raw.samples[c], raw.samples[4 + c]);
            assert_true(raw.samples[c] > 60 && raw.samples[8 + c] == 0);
        }
        static const uint16_t alphas[] = {255, 64, 0, 0};
        for (int x = 0; x < 4; x++) assert_int_equal(raw.samples[4 * x + 3], alphas[x]);
    }
    const struct raw deep =
        encode(image, "beauty", (struct png_options){.alpha = true, .is_deep = true});
    assert_int_equal(deep.samples[7], 16384);
    assert_int_equal(deep.samples[4], deep.samples[0]);
    image_destroy(&image);
}

/* An environment shines where nothing is, and through edges: what it brings cannot be taken out. */
TEST(colours_before_an_environment_stay)
{
    static const float pixels[][4] = {{0.4f, 0.2f, 0.1f, 0.25f}, {0.5f, 0.6f, 0.9f, 0}};
    struct image *image = make_row(beauty, pixels, 2);
    const struct raw cut = encode(image, "beauty", (struct png_options){.alpha = true});
    const struct raw whole = encode(image, "beauty", (struct png_options){0});
    for (int c = 0; c < 3; c++) assert_int_equal(cut.samples[c], whole.samples[c]);
    assert_int_equal(cut.samples[3], 64);
    for (int c = 0; c < 4; c++) assert_int_equal(cut.samples[4 + c], 0);
    image_destroy(&image);
}

TEST(only_colours_say_that_they_are_srgb)
{
    static const char *const names[4] = {"normal.X", "normal.Y", "normal.Z", "depth.Z"};
    static const float pixels[][4] = {{0, 1, -1, 2}, {0, 0, 1, 4}};
    struct image *image = make_row(names, pixels, 2);
    const struct png_options options = {.is_deep = true, .alpha = true, .view = VIEW_AGX};
    const struct raw normal = encode(image, "normal", options);
    const struct raw depth = encode(image, "depth", options);
    assert_false(normal.has_srgb || normal.has_gamma || depth.has_srgb || depth.has_gamma);
    assert_int_equal(normal.color_type, PNG_COLOR_TYPE_RGB);
    static const uint16_t normals[] = {32768, 65535, 0, 32768, 32768, 65535};
    assert_memory_equal(normal.samples, normals, sizeof normals);
    assert_int_equal(depth.samples[0], 32768);
    assert_int_equal(depth.samples[3], 65535);
    image_destroy(&image);
}
