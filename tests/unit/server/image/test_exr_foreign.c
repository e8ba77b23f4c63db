/* EXR files of other programs are read, or refused with advice. */
#include <OpenEXR/openexr.h>
#include <math.h>
#include <unistd.h>

#include "proto/half.h"
#include "tests/unit/server/image/exr_room.h"

EACH_TEST(make_dir, remove_dir);

/* A file as another program may write it: tiled or not, any pixel type, any codec. */
static void write_foreign(const char *path, bool tiled, exr_pixel_type_t type,
                          exr_compression_t codec, int32_t offset)
{
    exr_context_t file;
    int part;
    static uint8_t data[64 * 48 * 4];
    exr_attr_box2i_t window;
    for (int i = 0; i < 64 * 48; i++) {
        float v = (float)(i % 100) * 0.5f;
        uint32_t u = (uint32_t)i;
        uint16_t h = half_from_float(v);
        if (type == EXR_PIXEL_UINT) memcpy(data + i * 4, &u, 4);
        if (type == EXR_PIXEL_FLOAT) memcpy(data + i * 4, &v, 4);
        if (type == EXR_PIXEL_HALF) memcpy(data + i * 2, &h, 2);
    }
    int bytes = type == EXR_PIXEL_HALF ? 2 : 4;
    window.min.x = window.min.y = offset;
    window.max.x = offset + 63;
    window.max.y = offset + 47;
    assert_int_equal(exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    assert_int_equal(
        exr_add_part(file, NULL, tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part), 0);
    assert_int_equal(exr_initialize_required_attr_simple(file, 0, 64, 48, codec), 0);
    assert_int_equal(exr_set_data_window(file, 0, &window), 0);
    assert_int_equal(exr_add_channel(file, 0, "V", type, EXR_PERCEPTUALLY_LINEAR, 1, 1), 0);
    if (tiled)
        assert_int_equal(
            exr_set_tile_descriptor(file, 0, 20, 30, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN), 0);
    assert_int_equal(exr_write_header(file), 0);
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step_x = tiled ? 20 : 64, step_y = 30;
    if (!tiled) exr_get_scanlines_per_chunk(file, 0, &step_y);
    bool first = true;
    for (int32_t y = 0; y < 48; y += step_y) {
        for (int32_t x = 0; x < 64; x += step_x) {
            exr_chunk_info_t chunk;
            if (tiled)
                exr_write_tile_chunk_info(file, 0, x / 20, y / 30, 0, 0, &chunk);
            else
                exr_write_scanline_chunk_info(file, 0, offset + y, &chunk);
            if (first)
                assert_int_equal(exr_encoding_initialize(file, 0, &chunk, &encoder), 0);
            else
                assert_int_equal(exr_encoding_update(file, 0, &chunk, &encoder), 0);
            encoder.channels[0].encode_from_ptr = data + (y * 64 + x) * bytes;
            encoder.channels[0].user_pixel_stride = bytes;
            encoder.channels[0].user_line_stride = 64 * bytes;
            if (first) assert_int_equal(exr_encoding_choose_default_routines(file, 0, &encoder), 0);
            first = false;
            assert_int_equal(exr_encoding_run(file, 0, &encoder), 0);
        }
    }
    exr_encoding_destroy(file, &encoder);
    assert_int_equal(exr_finish(&file), 0);
}

TEST(files_of_other_programs_are_read)
{
    static const exr_compression_t codecs[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                               EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                               EXR_COMPRESSION_PIZ};
    static const exr_pixel_type_t types[] = {EXR_PIXEL_UINT, EXR_PIXEL_HALF, EXR_PIXEL_FLOAT};
    for (int n = 0; n < 5 * 3 * 2; n++) {
        exr_pixel_type_t type = types[n % 3];
        write_foreign(path_of("f.exr"), n >= 15, type, codecs[n % 5], n % 2 ? -13 : 40);
        struct image *image = read_back(path_of("f.exr"));
        assert_int_equal(image->width_px, 64);
        assert_int_equal(image->height_px, 48);
        for (int i = 0; i < 64 * 48; i++) {
            float expected = type == EXR_PIXEL_UINT ? (float)i : (float)(i % 100) * 0.5f;
            assert_true(image->data[i] == expected);
        }
        image_destroy(&image);
    }
}

TEST(a_reference_picture_is_read)
{
    char path[UNIT_PATH_BYTES];
    scene_path("cornell-box-bitterli/TungstenRender.exr", path);
    struct image *image = read_back(path);
    const struct plane *rgb[3];
    assert_true(image->width_px >= 100 && image->height_px >= 100);
    assert_true(image_layer_planes(image, "beauty", rgb));
    double sum = 0.0;
    size_t pixels = (size_t)image->width_px * (size_t)image->height_px;
    for (size_t i = 0; i < pixels; i++) {
        assert_true(isfinite(rgb[0]->data[i]) && rgb[0]->data[i] >= 0.0f);
        sum += (double)rgb[0]->data[i];
    }
    assert_true(sum / (double)pixels > 0.01 && sum / (double)pixels < 10.0);
    image_destroy(&image);
}

TEST(what_is_not_read_is_refused)
{
    struct image *image;
    struct fault fault = {0};
    assert_int_equal(exr_read(path_of("missing.exr"), &image, &fault), ERR_NOT_FOUND);
    assert_int_not_equal(exr_read(dir, &image, &fault), 0);
    exr_context_t file;
    int part;
    assert_int_equal(exr_start_write(&file, path_of("s.exr"), EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
    exr_initialize_required_attr_simple(file, 0, 4, 4, EXR_COMPRESSION_NONE);
    exr_add_channel(file, 0, "BY", EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LINEAR, 2, 2);
    assert_int_equal(exr_write_header(file), 0);
    static const uint8_t row[4];
    for (int y = 0; y < 4; y++) exr_write_scanline_chunk(file, 0, y, row, y % 2 ? 0 : 4);
    exr_finish(&file);
    if (!access(path_of("s.exr"), R_OK))
        assert_int_equal(exr_read(path_of("s.exr"), &image, &fault), ERR_UNSUPPORTED);
}

/* Environment maps are files of strangers: what reads DWA is not for them. */
TEST(dwa_in_memory_is_refused_with_advice)
{
    static const char *const names[] = {"R"};
    const struct exr_selection selection = {
        .channels = names, .channel_count = 1, .pixels_max = 100};
    const struct exr_metadata metadata = {.codec = EXR_CODEC_DWAA};
    struct image *image, *back;
    struct fault fault = {0};
    uint8_t bytes[4096];
    assert_int_equal(image_create(1, 4, 4, &image), 0);
    assert_int_equal(exr_write(path_of("dwa.exr"), image, &metadata, &fault), 0);
    image_destroy(&image);
    FILE *file = fopen(path_of("dwa.exr"), "rb");
    const size_t size_bytes = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_int_equal(exr_read_memory(bytes, size_bytes, "dwa.exr", &selection, &back, &fault),
                     ERR_UNSUPPORTED);
    assert_non_null(strstr(fault.detail, "ZIP or PIZ"));
}
