/* Environment maps in Radiance files come out as they are, hostile ones are errors. */

#include "tests/unit/import/image/environment_case.h"
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_HDR
#include <stb/stb_image.h>

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
