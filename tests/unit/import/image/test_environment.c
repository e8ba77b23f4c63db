/* Environment maps: Radiance and OpenEXR files come out as they are, hostile ones are errors. */
#include <OpenEXR/openexr.h>
#include <math.h>

#include "proto/half.h"
#include "proto/scene/environment.h"
#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_HDR
#include <stb/stb_image.h>

static struct environment_blob map;

static int import_map(const char *name)
{
    char path[256];
    int rc = room_import_blob(name, path);
    if (rc != 0) {
        assert_true(room_fault.detail[0] != '\0');
        return rc;
    }
    assert_int_equal(environment_map(path, &map, NULL), 0);
    assert_int_equal(room_stats.width_px, map.header->width_px);
    assert_int_equal(room_stats.height_px, map.header->height_px);
    assert_int_equal(room_stats.triangles, 0);
    return 0;
}

static void must_import(const char *name)
{
    if (import_map(name) != 0) fail_msg("%s: %s", room_fault.pointer, room_fault.detail);
}

static const float *texel(uint32_t x, uint32_t y)
{
    return map.texels + 3 * ((size_t)y * map.header->width_px + x);
}

/* ---- Radiance ---- */

static char bytes[1 << 16];
static size_t byte_count;

static void begin(const char *header)
{
    byte_count = strlen(header);
    memcpy(bytes, header, byte_count);
}

static void add(const void *data, size_t size_bytes)
{
    memcpy(bytes + byte_count, data, size_bytes);
    byte_count += size_bytes;
}

static void add_pixel(int r, int g, int b, int e)
{
    const uint8_t pixel[4] = {(uint8_t)r, (uint8_t)g, (uint8_t)b, (uint8_t)e};
    add(pixel, 4);
}

static int import_bytes(const char *name)
{
    room_write(name, bytes, byte_count);
    return import_map(name);
}

static void expect_texel(uint32_t x, uint32_t y, float r, float g, float b)
{
    const float *t = texel(x, y);
    if (!(t[0] == r && t[1] == g && t[2] == b))
        fail_msg("texel %u %u is %g %g %g", x, y, (double)t[0], (double)t[1], (double)t[2]);
}

#define HEAD "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n"

ALL_TESTS(room_open, room_close);

TEST(flat_pixels_are_read)
{
    begin(HEAD "\n-Y 2 +X 2\n");
    add_pixel(128, 64, 0, 129);
    add_pixel(0, 0, 0, 0);
    add_pixel(255, 1, 2, 120);
    add_pixel(1, 2, 3, 0); /* no exponent: black */
    assert_int_equal(import_bytes("map.hdr"), 0);
    expect_texel(0, 0, 1.0f, 0.5f, 0.0f);
    expect_texel(1, 0, 0.0f, 0.0f, 0.0f);
    expect_texel(0, 1, 255 * 0x1p-16f, 0x1p-16f, 2 * 0x1p-16f);
    expect_texel(1, 1, 0.0f, 0.0f, 0.0f);
    assert_true(map.header->mean[0] > 0.25f && map.header->mean[0] < 0.26f);
    environment_unmap(&map);
    /* the name does not matter, the first bytes do */
    assert_int_equal(import_bytes("map"), 0);
    environment_unmap(&map);
    assert_int_equal(import_bytes("map.glb"), 0);
    environment_unmap(&map);
}

TEST(old_runs_are_read)
{
    begin("#?RGBE\n\n-Y 1 +X 300\n"); /* no FORMAT is RGBE */
    add_pixel(128, 0, 0, 129);
    add_pixel(1, 1, 1, 3); /* and a second digit: 3 + 256 of them */
    add_pixel(1, 1, 1, 1);
    for (int i = 0; i < 40; i++) add_pixel(0, i, 0, 136);
    assert_int_equal(import_bytes("map.hdr"), 0);
    expect_texel(259, 0, 1.0f, 0.0f, 0.0f);
    expect_texel(260, 0, 0.0f, 0.0f, 0.0f);
    expect_texel(299, 0, 0.0f, 39.0f, 0.0f);
    environment_unmap(&map);
    begin(HEAD "\n-Y 1 +X 4\n");
    add_pixel(1, 1, 1, 2); /* nothing to repeat */
    assert_int_equal(import_bytes("map.hdr"), ERR_CORRUPT);
    begin(HEAD "\n-Y 1 +X 4\n");
    add_pixel(9, 1, 1, 2);
    add_pixel(1, 1, 1, 4); /* one more than there is room for */
    assert_int_equal(import_bytes("map.hdr"), ERR_CORRUPT);
    begin(HEAD "\n-Y 1 +X 4\n");
    add_pixel(9, 1, 1, 2);
    for (int i = 0; i < 5; i++) add_pixel(1, 1, 1, 0);
    assert_int_equal(import_bytes("map.hdr"), ERR_CORRUPT);
}

TEST(new_runs_are_read)
{
    static const uint8_t row[] = {2,   2,  0, 10, 138, 128,                     /* red: a run */
                                  10,  0,  1, 2,  3,   4,   5, 6, 7, 8, 9,      /* green: ten */
                                  129, 7,  9, 0,  0,   0,   0, 0, 0, 0, 0, 200, /* blue: 1 + 9 */
                                  138, 136};
    begin(HEAD "\n-Y 1 +X 10\n");
    add(row, sizeof row);
    assert_int_equal(import_bytes("map.hdr"), 0);
    expect_texel(0, 0, 128.0f, 0.0f, 7.0f);
    expect_texel(8, 0, 128.0f, 8.0f, 0.0f);
    expect_texel(9, 0, 128.0f, 9.0f, 200.0f);
    environment_unmap(&map);
    static const struct {
        size_t at;
        uint8_t value;
        int code;
    } wrong[] = {{3, 11, ERR_CORRUPT}, {4, 139, ERR_CORRUPT}, {6, 0, ERR_CORRUPT},
                 {6, 11, ERR_CORRUPT}, {2, 1, ERR_CORRUPT},   {4, 137, ERR_CORRUPT}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        begin(HEAD "\n-Y 1 +X 10\n");
        const size_t start = byte_count;
        add(row, sizeof row);
        bytes[start + wrong[i].at] = (char)wrong[i].value;
        assert_int_equal(import_bytes("map.hdr"), wrong[i].code);
        assert_string_equal(room_fault.pointer, "map.hdr: row 0");
    }
    for (size_t cut = 0; cut < sizeof row; cut++) {
        begin(HEAD "\n-Y 1 +X 10\n");
        add(row, cut);
        assert_int_equal(import_bytes("map.hdr"), ERR_TRUNCATED);
    }
}

TEST(pictures_that_are_turned_are_turned_back)
{
    static const char *const resolutions[] = {"-Y 2 +X 2\n", "-Y 2 -X 2\n", "+Y 2 +X 2\n",
                                              "+Y 2 -X 2\n"};
    for (uint32_t k = 0; k < 4; k++) {
        begin(HEAD "\n");
        add(resolutions[k], strlen(resolutions[k]));
        for (int i = 0; i < 4; i++) add_pixel(i, 0, 0, 136);
        assert_int_equal(import_bytes("map.hdr"), 0);
        for (uint32_t i = 0; i < 4; i++) expect_texel((i ^ k) & 1, (i ^ k) >> 1, (float)i, 0, 0);
        environment_unmap(&map);
    }
}

TEST(exposures_are_divided_out)
{
    begin(HEAD "EXPOSURE=4\nEXPOSURE= 0.5\nCOLORCORR=1 2 1\n\n-Y 1 +X 1\n");
    add_pixel(128, 64, 32, 129);
    assert_int_equal(import_bytes("map.hdr"), 0);
    expect_texel(0, 0, 0.5f, 0.25f, 0.125f);
    assert_true(room_warned("correction of colours"));
    environment_unmap(&map);
    static const char *const wrong[] = {"EXPOSURE=0\n", "EXPOSURE=-1\n",    "EXPOSURE=nan\n",
                                        "EXPOSURE=x\n", "EXPOSURE=1e-30\n", "EXPOSURE=1e30\n"};
    for (int i = 0; i < 6; i++) {
        begin(HEAD);
        add(wrong[i], strlen(wrong[i]));
        add("\n-Y 1 +X 1\n", 11);
        add_pixel(128, 64, 32, 129);
        assert_int_equal(import_bytes("map.hdr"), ERR_RANGE);
    }
}

TEST(headers_are_checked)
{
    static const struct {
        const char *text;
        int code;
    } wrong[] = {{"#?RADIANCE\n", ERR_TRUNCATED},
                 {"#?RADIANCE\n\n", ERR_TRUNCATED},
                 {"#?RADIANCE\n\n-Y 2 +X 2", ERR_TRUNCATED},
                 {"#?RADIANCE\n\n-Y 2 +X 2\n", ERR_TRUNCATED},
                 {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 2\n", ERR_UNSUPPORTED},
                 {"#?RADIANCE\n\n+X 2 -Y 2\n", ERR_UNSUPPORTED},
                 {"#?RADIANCE\n\n-Y 0 +X 2\n", ERR_SYNTAX},
                 {"#?RADIANCE\n\n-Y -3 +X 2\n", ERR_SYNTAX},
                 {"#?RADIANCE\n\n-Y 2 +X 2 and more\n", ERR_SYNTAX},
                 {"#?RADIANCE\n\nnothing\n", ERR_SYNTAX},
                 {"#?RADIANCE\n\n-Y 16385 +X 2\n", ERR_LIMIT},
                 {"#?RADIANCE\n\n-Y 2 +X 16385\n", ERR_LIMIT},
                 {"#?RADIANCE\n\n-Y 16384 +X 16384\n", ERR_LIMIT},
                 {"#?RADIANCE\n\n-Y 99999999999999999999 +X 2\n", ERR_SYNTAX}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        begin(wrong[i].text);
        const int rc = import_bytes("map.hdr");
        if (rc != wrong[i].code) fail_msg("%s: %s", wrong[i].text, error_name(rc));
        assert_memory_equal(room_fault.pointer, "map.hdr", 7);
    }
    begin("#?RADIANCE\n"); /* comments without end */
    while (byte_count < sizeof bytes - 100) add("# comment\n", 10);
    assert_int_equal(import_bytes("map.hdr"), ERR_TRUNCATED);
}

TEST(bright_texels_are_brought_down)
{
    begin(HEAD "\n-Y 1 +X 2\n");
    add_pixel(255, 0, 0, 255);
    add_pixel(255, 255, 0, 255);
    assert_int_equal(import_bytes("map.hdr"), 0);
    expect_texel(1, 0, 1e12f, 1e12f, 0.0f);
    assert_int_equal(room_warnings.count, 1);
    assert_string_equal(room_warnings.list[0].place, "texels[0][0].R");
    assert_int_equal(room_warnings.list[0].more, 2);
    environment_unmap(&map);
}

/* Imports a file of the folder of scenes from a copy in the room. */
static void import_copy(const char *name, char path[UNIT_PATH_BYTES])
{
    const char *base = strrchr(name, '/') + 1;
    char command[2 * UNIT_PATH_BYTES];
    scene_path(name, path);
    snprintf(command, sizeof command, "cp '%s' '%s'", path, room);
    assert_int_equal(system(command), 0);
    must_import(base);
}

TEST(real_skies_are_read_as_others_read_them)
{
    static const char *const names[] = {"hdr/park.hdr", "hdr/venice.hdr", "hdr/studio.hdr"};
    for (int i = 0; i < 3; i++) {
        char path[UNIT_PATH_BYTES];
        int width, height, channels;
        import_copy(names[i], path);
        float *expected = stbi_loadf(path, &width, &height, &channels, 3);
        assert_non_null(expected);
        assert_int_equal(map.header->width_px, width);
        assert_int_equal(map.header->height_px, height);
        assert_memory_equal(map.texels, expected, 12 * (size_t)width * (size_t)height);
        assert_int_equal(room_warnings.count, 0);
        environment_unmap(&map);
        stbi_image_free(expected);
    }
}

/* ---- OpenEXR ---- */

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

TEST(scenes_are_still_scenes)
{
    struct scene scene;
    assert_int_equal(room_import_text("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &scene), 0);
    assert_int_equal(room_stats.width_px, 0);
    assert_int_equal(room_stats.triangles, 1);
    scene_unmap(&scene);
    room_refuses("a.hdr", "#?SOMETHING\n", ERR_UNSUPPORTED, "a.hdr");
    assert_non_null(strstr(room_fault.detail, ".hdr or .exr"));
}
