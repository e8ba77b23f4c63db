/* Compressions of EXR files: which lose nothing, what DWA loses, equal bytes. */
#include <OpenEXR/openexr.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/half.h"
#include "tests/unit/server/image/exr_room.h"

EACH_TEST(make_dir, remove_dir);

static const enum exr_codec codecs[] = {EXR_CODEC_ZIP, EXR_CODEC_ZIPS, EXR_CODEC_PIZ,
                                        EXR_CODEC_DWAA, EXR_CODEC_NONE};

#define ALL 0x203fu /* beauty to depth, and error */

/* A smooth picture with some grain. */
static struct image *make_image(uint32_t layers, int32_t width, int32_t height)
{
    struct image *image;
    uint32_t random = 7;
    assert_int_equal(image_create(layers, width, height, &image), 0);
    for (uint32_t c = 0; c < image->channel_count; c++)
        for (int32_t y = 0; y < height; y++)
            for (int32_t x = 0; x < width; x++) {
                random = random * 1664525u + 1013904223u;
                const float grain = (float)(random >> 8) * 0x1p-24f;
                *plane_at(&image->channels[c].plane, x, y) =
                    0.5f + 0.3f * sinf(0.1f * (float)(x + (int32_t)c * y)) + 0.02f * grain;
            }
    return image;
}

static void write_file(const char *name, const struct image *image, enum exr_codec codec, bool half)
{
    struct fault fault = {0};
    const struct exr_metadata m = {.job = "job", .spp = 1, .codec = codec, .half = half};
    if (exr_write(path_of(name), image, &m, &fault)) fail_msg("%s", fault.detail);
}

static struct image *read_file(const char *name)
{
    struct image *image = NULL;
    struct fault fault = {0};
    if (exr_read(path_of(name), &image, &fault)) fail_msg("%s", fault.detail);
    return image;
}

static exr_compression_t compression_of(const char *name)
{
    exr_context_t file;
    exr_compression_t compression;
    assert_int_equal(exr_start_read(&file, path_of(name), NULL), 0);
    assert_int_equal(exr_get_compression(file, 0, &compression), 0);
    exr_finish(&file);
    return compression;
}

static size_t size_of(const char *name)
{
    const int fd = open(path_of(name), O_RDONLY);
    const off_t size_bytes = lseek(fd, 0, SEEK_END);
    close(fd);
    return (size_t)size_bytes;
}

TEST(files_have_the_compression_that_was_asked_for)
{
    static const exr_compression_t wanted[] = {EXR_COMPRESSION_ZIP, EXR_COMPRESSION_ZIPS,
                                               EXR_COMPRESSION_PIZ, EXR_COMPRESSION_DWAA,
                                               EXR_COMPRESSION_NONE};
    struct image *image = make_image(ALL, 40, 35);
    for (size_t k = 0; k < 5; k++) {
        write_file("a.exr", image, codecs[k], k % 2 == 0);
        assert_int_equal(compression_of("a.exr"), wanted[k]);
    }
    image_destroy(&image);
}

/* Odd sizes too, whose last chunk is not whole. */
TEST(all_but_dwa_lose_nothing)
{
    static const int32_t sizes[][2] = {{1, 1}, {33, 1}, {1, 70}, {97, 65}};
    for (size_t n = 0; n < 4; n++) {
        struct image *image = make_image(ALL, sizes[n][0], sizes[n][1]);
        for (size_t k = 0; k < 5; k++) {
            if (codecs[k] == EXR_CODEC_DWAA) continue;
            write_file("a.exr", image, codecs[k], false);
            struct image *back = read_file("a.exr");
            assert_int_equal(back->channel_count, image->channel_count);
            for (uint32_t c = 0; c < image->channel_count; c++)
                assert_memory_equal(image->channels[c].plane.data,
                                    image_plane(back, image->channels[c].name)->data,
                                    (size_t)sizes[n][0] * (size_t)sizes[n][1] * sizeof(float));
            image_destroy(&back);
        }
        image_destroy(&image);
    }
}

/* Colours come back as people see them; alpha, depths and counts stay. DWA takes Y for luminance,
 * that of normals, too. */
TEST(dwa_loses_of_colours_alone)
{
    for (int half = 0; half < 2; half++) {
        struct image *image = make_image(ALL, 97, 65);
        write_file("a.exr", image, EXR_CODEC_DWAA, half);
        struct image *back = read_file("a.exr");
        double loss = 0;
        for (uint32_t c = 0; c < image->channel_count; c++) {
            const char *name = image->channels[c].name;
            const bool is_color = strchr("RGBY", name[strlen(name) - 1]) != NULL;
            const bool is_float = !half || !strcmp(name, "depth.Z");
            const struct plane *a = &image->channels[c].plane, *b = image_plane(back, name);
            for (int32_t y = 0; y < 65; y++)
                for (int32_t x = 0; x < 97; x++) {
                    uint16_t bits;
                    float v = *plane_at(a, x, y);
                    if (!is_float) {
                        half_from_floats(&v, &bits, 1);
                        half_to_floats(&bits, &v, 1);
                    }
                    const double d = fabs((double)*plane_at(b, x, y) - (double)v);
                    if (is_color)
                        loss += d;
                    else
                        assert_true(d == 0);
                    assert_true(d < 0.05);
                }
        }
        assert_true(loss > 0);
        image_destroy(&back);
        image_destroy(&image);
    }
}

TEST(dwa_is_much_smaller)
{
    struct image *image = make_image(1, 256, 256);
    write_file("a.exr", image, EXR_CODEC_ZIP, false);
    const size_t zip = size_of("a.exr");
    write_file("a.exr", image, EXR_CODEC_DWAA, false);
    assert_true(2 * size_of("a.exr") < zip);
    image_destroy(&image);
}

TEST(rows_from_the_top_are_the_same_bytes)
{
    struct image *image = make_image(ALL, 61, 77);
    for (size_t k = 0; k < 5; k++) {
        const struct exr_metadata m = {.job = "job", .spp = 1, .codec = codecs[k]};
        struct exr_rows *rows;
        struct fault fault;
        char command[9000], whole[4200];
        write_file("a.exr", image, codecs[k], false);
        assert_int_equal(exr_rows_begin(path_of("b.exr"), image, &m, &rows, &fault), 0);
        for (int32_t end = 5; end < 77; end += 9)
            assert_int_equal(exr_rows_write(rows, end, &fault), 0);
        assert_int_equal(exr_rows_finish(&rows, &fault), 0);
        snprintf(whole, sizeof whole, "%s", path_of("a.exr"));
        snprintf(command, sizeof command, "cmp -s '%s' '%s'", whole, path_of("b.exr"));
        assert_int_equal(system(command), 0);
    }
    image_destroy(&image);
}

TEST(a_damaged_dwa_file_is_an_error)
{
    struct image *image = make_image(ALL, 64, 64), *back = NULL;
    struct fault fault = {0};
    write_file("a.exr", image, EXR_CODEC_DWAA, true);
    const size_t size_bytes = size_of("a.exr");
    for (size_t cut = size_bytes - 1; cut > size_bytes / 2; cut -= 500) {
        assert_int_equal(truncate(path_of("a.exr"), (off_t)cut), 0);
        assert_int_not_equal(exr_read(path_of("a.exr"), &back, &fault), 0);
        assert_null(back);
        assert_true(fault.detail[0] != '\0');
    }
    image_destroy(&image);
}
