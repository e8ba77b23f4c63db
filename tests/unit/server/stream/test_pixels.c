/* The pixel feed's blocks: every changed pixel is sent, once, newest, inside the image. */
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "proto/job/job.h"
#include "server/stream/pixels.h"
#include "tests/unit/unit.h"

static const struct {
    int32_t width_px, height_px;
} sizes[] = {{1, 1}, {64, 64}, {65, 64}, {64, 65}, {250, 200}, {720, 720}, {63, 4097}, {8192, 3}};
#define SIZES (sizeof sizes / sizeof sizes[0])

static uint32_t read_u32(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

TEST(whole_image_comes_once)
{
    for (size_t i = 0; i < SIZES; i++) {
        struct pixel_blocks b;
        struct rect block;
        int64_t area = 0;
        int32_t w = sizes[i].width_px, h = sizes[i].height_px;
        assert_int_equal(pixel_blocks_init(&b, w, h), 0);
        assert_false(pixel_blocks_take(&b, &block));
        pixel_blocks_mark(&b, (struct rect){0, 0, w, h});
        assert_int_equal(b.count, b.columns * b.rows);
        while (pixel_blocks_take(&b, &block)) {
            assert_true(block.x0 >= 0 && block.y0 >= 0 && block.x1 <= w && block.y1 <= h);
            assert_true(rect_width(block) <= 64 && rect_height(block) <= 64);
            area += rect_area(block);
        }
        assert_int_equal(area, (int64_t)w * h);
        pixel_blocks_fini(&b);
    }
}

TEST(random_marks_match_a_plain_map)
{
    enum { COLUMNS = 12, ROWS = 9 };
    struct pixel_blocks b;
    bool map[ROWS][COLUMNS] = {{false}};
    srand(5);
    assert_int_equal(pixel_blocks_init(&b, COLUMNS * 64 - 13, ROWS * 64 - 1), 0);
    for (int round = 0; round < 2000; round++) {
        int x = rand() % 900 - 60, y = rand() % 700 - 60;
        struct rect r = {x, y, x + rand() % 90, y + rand() % 90}, block;
        pixel_blocks_mark(&b, r);
        for (int j = 0; j < ROWS; j++)
            for (int i = 0; i < COLUMNS; i++) {
                struct rect cell = {i * 64, j * 64, i * 64 + 64, j * 64 + 64};
                cell = rect_intersect(cell, (struct rect){0, 0, b.width_px, b.height_px});
                map[j][i] |= !rect_is_empty(rect_intersect(cell, r));
            }
        for (int n = rand() % 4; n > 0 && pixel_blocks_take(&b, &block); n--) {
            assert_true(map[block.y0 / 64][block.x0 / 64]);
            map[block.y0 / 64][block.x0 / 64] = false;
        }
        uint32_t left = 0;
        for (int j = 0; j < ROWS; j++)
            for (int i = 0; i < COLUMNS; i++) left += map[j][i];
        assert_int_equal(b.count, left);
    }
    pixel_blocks_fini(&b);
}

TEST(no_block_starves)
{
    struct pixel_blocks b;
    struct rect block;
    bool last_seen = false;
    assert_int_equal(pixel_blocks_init(&b, 640, 640), 0);
    pixel_blocks_mark(&b, (struct rect){639, 639, 640, 640});
    for (int i = 0; i < 3 && !last_seen; i++) { /* the first block changes all the time */
        pixel_blocks_mark(&b, (struct rect){0, 0, 1, 1});
        assert_true(pixel_blocks_take(&b, &block));
        last_seen = block.x0 == 576 && block.y0 == 576;
    }
    assert_true(last_seen);
    pixel_blocks_fini(&b);
}

TEST(joiners_see_what_is_there)
{
    struct pixel_changes changes;
    struct pixel_blocks reader;
    struct rect block;
    assert_int_equal(pixel_changes_init(&changes, 300, 300), 0);
    assert_int_equal(pixel_blocks_init(&reader, 300, 300), 0);
    pixel_changes_mark(&changes, (struct rect){100, 100, 101, 101}, 7);
    pixel_blocks_join(&reader, &changes, 0);
    pixel_blocks_join(&reader, &changes, 0);
    assert_int_equal(reader.count, 1);
    assert_true(pixel_blocks_take(&reader, &block));
    assert_int_equal(block.x0, 64);
    pixel_changes_fini(&changes);
    pixel_blocks_fini(&reader);
}

TEST(returners_see_what_has_changed_since)
{
    struct pixel_changes changes;
    struct pixel_blocks reader;
    struct rect block;
    assert_int_equal(pixel_changes_init(&changes, 200, 130), 0);
    assert_int_equal(pixel_blocks_init(&reader, 200, 130), 0);
    pixel_changes_mark(&changes, (struct rect){0, 0, 200, 130}, 10);
    pixel_changes_mark(&changes, (struct rect){199, 129, 200, 130}, 11);
    pixel_changes_mark(&changes, (struct rect){300, 0, 400, 64}, 12); /* outside */
    pixel_blocks_join(&reader, &changes, 11);
    assert_int_equal(reader.count, 0);
    pixel_blocks_join(&reader, &changes, 10);
    assert_int_equal(reader.count, 1);
    assert_true(pixel_blocks_take(&reader, &block));
    assert_true(block.x0 == 192 && block.y0 == 128 && block.x1 == 200 && block.y1 == 130);
    pixel_blocks_join(&reader, &changes, 9);
    assert_int_equal(reader.count, 4 * 3);
    pixel_changes_fini(&changes);
    pixel_blocks_fini(&reader);
}

TEST(block_bytes)
{
    static uint8_t out[PIXELS_MESSAGE_BYTES];
    struct image *image = NULL;
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_DEPTH, 70, 66, &image), 0);
    const struct plane *green = image_plane(image, "G"), *depth = image_plane(image, "depth.Z");
    *plane_at(green, 65, 64) = 0.5f;
    *plane_at(green, 69, 65) = 1e9f; /* clamped, not infinite */
    *plane_at(depth, 64, 64) = 3;
    struct rect block = {64, 64, 70, 66};
    size_t n = pixels_write_block(out, image, "beauty", PIXELS_F16, block, UINT64_C(0x100000002));
    assert_int_equal(n, PIXELS_HEADER_BYTES + 6 * 2 * 3 * 2);
    assert_memory_equal(out, "SWPX\1\0\1\0", 8);
    assert_int_equal(read_u32(out + 8), 64);
    assert_int_equal(read_u32(out + 12), 64);
    assert_int_equal(read_u32(out + 16), 6);
    assert_int_equal(read_u32(out + 20), 2);
    assert_int_equal(read_u32(out + 24), 2);
    assert_int_equal(read_u32(out + 28), 1);
    uint16_t halves[36];
    memcpy(halves, out + PIXELS_HEADER_BYTES, sizeof halves);
    for (int i = 0; i < 36; i++) {
        float want = i == 1 * 3 + 1 ? 0.5f : i == (6 + 5) * 3 + 1 ? HALF_MAX : 0;
        assert_true(half_to_float(halves[i]) == want);
    }
    assert_int_equal(pixels_write_block(out, image, "depth", PIXELS_F16, block, 1), n);
    memcpy(halves, out + PIXELS_HEADER_BYTES, sizeof halves);
    assert_true(half_to_float(halves[0]) == 3 && half_to_float(halves[2]) == 3);
    n = pixels_write_block(out, image, "beauty", PIXELS_F32, block, 1);
    assert_int_equal(n, PIXELS_HEADER_BYTES + 6 * 2 * 3 * 4);
    assert_memory_equal(out, "SWPX\1\0\2\0", 8);
    float first_row[18];
    memcpy(first_row, out + PIXELS_HEADER_BYTES, sizeof first_row);
    assert_true(first_row[4] == 0.5f && first_row[3] == 0);
    memcpy(first_row, out + n - 6 * 3 * 4, sizeof first_row);
    assert_true(first_row[16] == 1e9f); /* as it is */
    assert_int_equal(pixels_write_block(out, image, "normal", PIXELS_F16, block, 1), 0);
    image_destroy(&image);
}

TEST(size_bytes)
{
    uint8_t out[PIXELS_HEADER_BYTES];
    pixels_write_size(out, 3840, 2160, 9);
    assert_int_equal(read_u32(out), PIXELS_MAGIC);
    assert_int_equal(read_u32(out + 8), 3840);
    assert_int_equal(read_u32(out + 12), 2160);
    assert_int_equal(read_u32(out + 16), 0);
    assert_int_equal(read_u32(out + 20), 0);
    assert_int_equal(read_u32(out + 24), 9);
}

/* Alpha goes along where it is asked for, the layer has it and the block is not opaque. */
TEST(alpha_comes_where_it_says_something)
{
    static uint8_t out[PIXELS_MESSAGE_BYTES];
    const struct rect block = {2, 3, 8, 5};
    struct image *image;
    float alpha[12];
    uint16_t half;
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_ALBEDO, 16, 16, &image), 0);
    const struct plane *plane = image_plane(image, "A");
    for (int32_t y = 0; y < 16; y++)
        for (int32_t x = 0; x < 16; x++) *plane_at(plane, x, y) = 1.0f;
    const size_t plain = PIXELS_HEADER_BYTES + 6 * 2 * 3 * 4;
    assert_int_equal(pixels_write_block(out, image, "beauty", PIXELS_F32_ALPHA, block, 1), plain);
    assert_int_equal(out[6], PIXELS_F32);
    *plane_at(plane, 3, 4) = 0.25f;
    assert_int_equal(pixels_write_block(out, image, "beauty", PIXELS_F32, block, 1), plain);
    assert_int_equal(pixels_write_block(out, image, "albedo", PIXELS_F32_ALPHA, block, 1), plain);
    assert_int_equal(pixels_write_block(out, image, "beauty", PIXELS_F32_ALPHA, block, 1),
                     plain + sizeof alpha);
    assert_int_equal(out[6], PIXELS_F32_ALPHA);
    memcpy(alpha, out + plain, sizeof alpha);
    assert_true(alpha[0] == 1.0f && alpha[7] == 0.25f);
    assert_int_equal(pixels_write_block(out, image, "beauty", PIXELS_F16_ALPHA, block, 1),
                     PIXELS_HEADER_BYTES + 6 * 2 * 4 * 2);
    assert_int_equal(out[6], PIXELS_F16_ALPHA);
    memcpy(&half, out + PIXELS_HEADER_BYTES + 6 * 2 * 3 * 2 + 7 * 2, sizeof half);
    assert_int_equal(half, 0x3400);
    image_destroy(&image);
}
