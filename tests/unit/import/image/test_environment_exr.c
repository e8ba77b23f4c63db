/* Environment maps in OpenEXR files come out as they are, hostile ones are errors. */
#include <OpenEXR/openexr.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "proto/half.h"
#include "tests/unit/import/image/environment_case.h"

ALL_TESTS(room_open, room_close);

#define WIDTH  50
#define HEIGHT 37

struct exr_case {
    const char *names[5];
    exr_pixel_type_t types[5];
    exr_compression_t codec;
    bool tiled;
    int32_t offset; /* of the display window */
    int32_t cut;    /* columns that the data window lacks */
};

static float value_of(int channel, int i)
{
    return (float)(i * 7 % 100 + channel) * 0.25f;
}

static uint8_t planes[5][WIDTH * HEIGHT * 4];

static void fill_planes(const struct exr_case *c)
{
    for (int k = 0; k < 5 && c->names[k]; k++)
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const float v = value_of(k, i);
            const uint16_t h = half_from_float(v);
            const uint32_t u = (uint32_t)v;
            if (c->types[k] == EXR_PIXEL_FLOAT) memcpy(planes[k] + 4 * i, &v, 4);
            if (c->types[k] == EXR_PIXEL_UINT) memcpy(planes[k] + 4 * i, &u, 4);
            if (c->types[k] == EXR_PIXEL_HALF) memcpy(planes[k] + 2 * i, &h, 2);
        }
}

static void write_chunk(exr_context_t file, const exr_chunk_info_t *chunk, int32_t x, int32_t y,
                        exr_encode_pipeline_t *encoder, const struct exr_case *c)
{
    const bool first = encoder->channel_count == 0;
    if (first)
        assert_int_equal(exr_encoding_initialize(file, 0, chunk, encoder), 0);
    else
        assert_int_equal(exr_encoding_update(file, 0, chunk, encoder), 0);
    for (int16_t n = 0; n < encoder->channel_count; n++)
        for (int k = 0; k < 5 && c->names[k]; k++) {
            if (strcmp(c->names[k], encoder->channels[n].channel_name) != 0) continue;
            const int size = c->types[k] == EXR_PIXEL_HALF ? 2 : 4;
            encoder->channels[n].encode_from_ptr = planes[k] + (y * WIDTH + x) * size;
            encoder->channels[n].user_pixel_stride = size;
            encoder->channels[n].user_line_stride = WIDTH * size;
        }
    if (first) assert_int_equal(exr_encoding_choose_default_routines(file, 0, encoder), 0);
    assert_int_equal(exr_encoding_run(file, 0, encoder), 0);
}

static void write_exr(const char *name, const struct exr_case *c)
{
    char path[256];
    exr_context_t file;
    int part;
    const int32_t width = WIDTH - c->cut;
    exr_attr_box2i_t display, window;
    window.min.x = window.min.y = c->offset;
    window.max.x = c->offset + width - 1;
    window.max.y = c->offset + HEIGHT - 1;
    display = window;
    display.max.x += c->cut;
    snprintf(path, sizeof path, "%s/%s", room, name);
    assert_int_equal(exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    exr_add_part(file, NULL, c->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part);
    exr_initialize_required_attr_simple(file, 0, WIDTH, HEIGHT, c->codec);
    exr_set_data_window(file, 0, &window);
    exr_set_display_window(file, 0, &display);
    for (int k = 0; k < 5 && c->names[k]; k++)
        exr_add_channel(file, 0, c->names[k], c->types[k], EXR_PERCEPTUALLY_LINEAR, 1, 1);
    if (c->tiled) exr_set_tile_descriptor(file, 0, 20, 16, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    assert_int_equal(exr_write_header(file), 0);
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step_x = c->tiled ? 20 : width, step_y = 16;
    if (!c->tiled) exr_get_scanlines_per_chunk(file, 0, &step_y);
    for (int32_t y = 0; y < HEIGHT; y += step_y)
        for (int32_t x = 0; x < width; x += step_x) {
            exr_chunk_info_t chunk;
            if (c->tiled)
                exr_write_tile_chunk_info(file, 0, x / 20, y / 16, 0, 0, &chunk);
            else
                exr_write_scanline_chunk_info(file, 0, c->offset + y, &chunk);
            write_chunk(file, &chunk, x, y, &encoder, c);
        }
    exr_encoding_destroy(file, &encoder);
    assert_int_equal(exr_finish(&file), 0);
}

static void check_texels(const int channels[3])
{
    assert_int_equal(map.header->width_px, WIDTH);
    assert_int_equal(map.header->height_px, HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 3; c++) assert_true(map.texels[3 * i + c] == value_of(channels[c], i));
}

TEST(exr_files_are_read_whatever_their_codec)
{
    static const exr_compression_t codecs[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                               EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                               EXR_COMPRESSION_PIZ};
    static const exr_pixel_type_t types[] = {EXR_PIXEL_HALF, EXR_PIXEL_FLOAT};
    for (int n = 0; n < 20; n++) {
        const exr_pixel_type_t type = types[n % 2];
        const struct exr_case c = {.names = {"R", "G", "B"},
                                   .types = {type, type, type},
                                   .codec = codecs[n % 5],
                                   .tiled = n >= 10,
                                   .offset = n % 3 ? 0 : -7};
        fill_planes(&c);
        write_exr("map.exr", &c);
        must_import("map.exr");
        check_texels((const int[3]){0, 1, 2});
        environment_unmap(&map);
    }
}

TEST(other_channels_are_passed_over)
{
    for (int n = 0; n < 8; n++) {
        const struct exr_case c = {.names = {"A", "R", "G", "B", n < 4 ? "Z" : "Y"},
                                   .types = {EXR_PIXEL_HALF, EXR_PIXEL_FLOAT, EXR_PIXEL_HALF,
                                             EXR_PIXEL_FLOAT,
                                             n % 4 < 2 ? EXR_PIXEL_FLOAT : EXR_PIXEL_UINT},
                                   .codec = n % 2 ? EXR_COMPRESSION_PIZ : EXR_COMPRESSION_ZIP,
                                   .tiled = n == 3 || n == 4};
        fill_planes(&c);
        write_exr("map.exr", &c);
        must_import("map.exr");
        check_texels((const int[3]){1, 2, 3});
        environment_unmap(&map);
    }
}

TEST(luminance_alone_is_grey)
{
    struct exr_case c = {.names = {"Y", "A"},
                         .types = {EXR_PIXEL_HALF, EXR_PIXEL_HALF},
                         .codec = EXR_COMPRESSION_ZIP};
    fill_planes(&c);
    write_exr("map.exr", &c);
    must_import("map.exr");
    check_texels((const int[3]){0, 0, 0});
    environment_unmap(&map);
    c.names[1] = "RY";
    write_exr("map.exr", &c);
    assert_int_equal(import_map("map.exr"), ERR_UNSUPPORTED);
}

TEST(what_is_no_map_is_refused)
{
    struct exr_case c = {.names = {"R", "G"}, .types = {EXR_PIXEL_HALF, EXR_PIXEL_HALF}};
    fill_planes(&c);
    write_exr("map.exr", &c);
    assert_int_equal(import_map("map.exr"), ERR_MISSING);
    assert_non_null(strstr(room_fault.detail, "channel B"));
    c.names[0] = "depth.Z";
    c.names[1] = "mask";
    write_exr("map.exr", &c);
    assert_int_equal(import_map("map.exr"), ERR_MISSING);
    c = (struct exr_case){.names = {"R", "G", "B"},
                          .types = {EXR_PIXEL_HALF, EXR_PIXEL_HALF, EXR_PIXEL_HALF},
                          .cut = 3};
    write_exr("map.exr", &c);
    assert_int_equal(import_map("map.exr"), ERR_UNSUPPORTED);
    assert_non_null(strstr(room_fault.detail, "display window"));
}

TEST(a_large_exr_is_refused_before_it_is_read)
{
    char path[256];
    exr_context_t file;
    int part;
    snprintf(path, sizeof path, "%s/map.exr", room);
    assert_int_equal(exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
    exr_initialize_required_attr_simple(file, 0, 16384, 16384, EXR_COMPRESSION_NONE);
    exr_add_channel(file, 0, "Y", EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    assert_int_equal(exr_write_header(file), 0);
    /* The library deletes what is not whole: keep a copy. */
    char command[600];
    snprintf(command, sizeof command, "cp '%s' '%s.kept'", path, path);
    assert_int_equal(system(command), 0);
    exr_finish(&file);
    const int rc = import_map("map.exr.kept");
    assert_true(rc == ERR_LIMIT || rc == ERR_CORRUPT);
}

TEST(strange_texels_are_repaired)
{
    const struct exr_case c = {.names = {"R", "G", "B"},
                               .types = {EXR_PIXEL_FLOAT, EXR_PIXEL_FLOAT, EXR_PIXEL_FLOAT},
                               .codec = EXR_COMPRESSION_ZIP};
    static const float strange[] = {NAN, -3.0f, INFINITY, -INFINITY, 1e13f, -NAN};
    static const float expected[] = {0.0f, 0.0f, 65504.0f, 0.0f, 1e12f, 0.0f};
    fill_planes(&c);
    for (int i = 0; i < 6; i++) memcpy(planes[1] + 4 * (WIDTH + i), &strange[i], 4);
    write_exr("map.exr", &c);
    must_import("map.exr");
    for (uint32_t i = 0; i < 6; i++) assert_true(texel(i, 1)[1] == expected[i]);
    assert_true(texel(6, 1)[1] == value_of(1, WIDTH + 6));
    assert_true(map.header->maximum[1] == 1e12f);
    assert_int_equal(room_warnings.count, 4);
    assert_true(room_warned("no number") && room_warned("negative") && room_warned("infinite") &&
                room_warned("above the limit"));
    /* Whoever reads the blob learns of it, too. */
    const char *end = map.warnings + map.header->warning_bytes;
    int sentences = 0;
    for (const char *at = map.warnings; at < end; at += strlen(at) + 1) sentences++;
    assert_int_equal(sentences, 4);
    assert_non_null(strstr(map.warnings, "is no number"));
    assert_string_equal(room_warnings.list[0].place, "texels[1][0].G");
    assert_int_equal(room_warnings.list[0].more, 1);
    environment_unmap(&map);
}

TEST(damaged_exr_files_end_cleanly)
{
    const struct exr_case c = {.names = {"R", "G", "B"},
                               .types = {EXR_PIXEL_HALF, EXR_PIXEL_HALF, EXR_PIXEL_HALF},
                               .codec = EXR_COMPRESSION_PIZ};
    char path[256];
    fill_planes(&c);
    write_exr("whole.exr", &c);
    snprintf(path, sizeof path, "%s/whole.exr", room);
    FILE *file = fopen(path, "rb");
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_true(size > 500 && size < sizeof bytes);
    for (byte_count = 4; byte_count < size; byte_count += 13)
        assert_int_not_equal(import_bytes("map.exr"), 0);
    byte_count = size;
    for (size_t i = 0; i < 400; i++) {
        const size_t at = 4 + i * 7919 % (i < 200 ? 300 : size - 4);
        bytes[at] = (char)(bytes[at] ^ (1 << i % 8));
        if (import_bytes("map.exr") == 0) environment_unmap(&map);
        bytes[at] = (char)(bytes[at] ^ (1 << i % 8));
    }
}

TEST(the_living_rooms_sky_is_read)
{
    char path[UNIT_PATH_BYTES];
    import_copy("living-room/textures/Sky 19.exr", path);
    assert_int_equal(map.header->width_px, 2048);
    assert_int_equal(map.header->height_px, 1024);
    print_message("# mean %g %g %g\n", (double)map.header->mean[0], (double)map.header->mean[1],
                  (double)map.header->mean[2]);
    assert_true(map.header->mean[2] > 0.1f);
    environment_unmap(&map);
}
