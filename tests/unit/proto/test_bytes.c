/* Reader and writer: what is written reads back, and nothing outside the input is ever read. */
#include <stdlib.h>
#include <string.h>

#include "proto/bytes.h"
#include "proto/error.h"
#include "tests/unit/unit.h"

static void write_one_of_each(struct bytes_writer *w)
{
    const float row[3] = {1.0f, -2.5f, 0.0f};
    bytes_write_u8(w, 0x01);
    bytes_write_u16(w, 0x0203);
    bytes_write_u32(w, 0x04050607u);
    bytes_write_u64(w, 0x08090a0b0c0d0e0full);
    bytes_write_f32(w, 1.5f);
    bytes_write_f32s(w, row, 3);
    bytes_write_string(w, "tile");
    bytes_write_raw(w, "\xff\xfe", 2);
}

TEST(writes_little_endian)
{
    static const uint8_t expected[] = {
        0x01, 0x03, 0x02, 0x07, 0x06, 0x05, 0x04, 0x0f, 0x0e, 0x0d, 0x0c, 0x0b,
        0x0a, 0x09, 0x08, 0x00, 0x00, 0xc0, 0x3f,       /* 1.5 */
        0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x20, 0xc0, /* 1, -2.5 */
        0x00, 0x00, 0x00, 0x00, 0x04, 0x00, 't',  'i',  'l',  'e',  0xff, 0xfe};
    struct bytes_writer w;
    bytes_writer_init(&w);
    write_one_of_each(&w);
    assert_false(w.failed);
    assert_int_equal(w.size_bytes, sizeof expected);
    assert_memory_equal(w.data, expected, sizeof expected);
    bytes_writer_fini(&w);
    assert_null(w.data);
}

static void read_one_of_each(struct bytes_reader *r)
{
    float row[3];
    char text[8];
    uint8_t raw[2];
    bytes_read_raw(r, raw, 1);
    bytes_read_u16(r);
    bytes_read_u32(r);
    bytes_read_u64(r);
    bytes_read_f32(r);
    bytes_read_f32s(r, row, 3);
    bytes_read_string(r, text, sizeof text);
    bytes_read_raw(r, raw, sizeof raw);
}

TEST(reads_back)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    write_one_of_each(&w);
    struct bytes_reader r;
    bytes_reader_init(&r, w.data, w.size_bytes);
    float row[3];
    char text[5];
    uint8_t raw[2];
    bytes_read_raw(&r, raw, 1);
    assert_int_equal(raw[0], 0x01);
    assert_int_equal(bytes_read_u16(&r), 0x0203);
    assert_int_equal(bytes_read_u32(&r), 0x04050607u);
    assert_true(bytes_read_u64(&r) == 0x08090a0b0c0d0e0full);
    assert_true(bytes_read_f32(&r) == 1.5f);
    bytes_read_f32s(&r, row, 3);
    assert_true(row[0] == 1.0f && row[1] == -2.5f && row[2] == 0.0f);
    bytes_read_string(&r, text, sizeof text);
    assert_string_equal(text, "tile");
    assert_int_equal(bytes_finish(&r), ERR_TRAILING);
    bytes_read_raw(&r, raw, sizeof raw);
    assert_memory_equal(raw, "\xff\xfe", 2);
    assert_int_equal(bytes_left(&r), 0);
    assert_int_equal(bytes_finish(&r), ERR_OK);
    bytes_writer_fini(&w);
}

/* Each shorter input, in memory of exactly its size so that a sanitizer sees a read beyond. */
TEST(every_truncation_fails)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    write_one_of_each(&w);
    for (size_t size_bytes = 0; size_bytes < w.size_bytes; size_bytes++) {
        uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
        assert_non_null(exact);
        memcpy(exact, w.data, size_bytes);
        struct bytes_reader r;
        bytes_reader_init(&r, exact, size_bytes);
        read_one_of_each(&r);
        assert_true(r.failed);
        assert_int_equal(bytes_finish(&r), ERR_TRUNCATED);
        assert_int_equal(bytes_left(&r), 0);
        free(exact);
    }
    bytes_writer_fini(&w);
}

TEST(failed_reader_yields_zeros)
{
    static const uint8_t data[] = {0xff, 0xff, 0xff};
    struct bytes_reader r;
    bytes_reader_init(&r, data, sizeof data);
    assert_int_equal(bytes_read_u32(&r), 0);
    assert_true(r.failed);
    assert_int_equal(bytes_read_u16(&r), 0); /* three bytes are left, but it stays failed */
    assert_null(bytes_borrow(&r, 0));
    float row[2] = {7.0f, 7.0f};
    bytes_read_f32s(&r, row, 2);
    assert_true(row[0] == 0.0f && row[1] == 0.0f);
    bytes_read_f32s(&r, row, SIZE_MAX);
    assert_int_equal(bytes_finish(&r), ERR_TRUNCATED);
}

TEST(empty_input)
{
    struct bytes_reader r;
    bytes_reader_init(&r, NULL, 0);
    assert_int_equal(bytes_finish(&r), ERR_OK);
    assert_non_null(bytes_borrow(&r, 0));
    assert_int_equal(bytes_read_u16(&r), 0);
    assert_int_equal(bytes_finish(&r), ERR_TRUNCATED);
    bytes_reader_init(&r, NULL, 4);
    assert_int_equal(bytes_finish(&r), ERR_TRUNCATED);
}

static int read_text(const void *data, size_t size_bytes, char *out, size_t capacity)
{
    struct bytes_reader r;
    bytes_reader_init(&r, data, size_bytes);
    bytes_read_string(&r, out, capacity);
    return bytes_finish(&r);
}

TEST(strings_are_bounded)
{
    char out[4];
    assert_int_equal(read_text("\x03\x00"
                               "abc",
                               5, out, sizeof out),
                     ERR_OK);
    assert_string_equal(out, "abc");
    assert_int_equal(read_text("\x00\x00", 2, out, sizeof out), ERR_OK);
    assert_string_equal(out, "");
    /* As long as the capacity: no room for the end. */
    assert_int_equal(read_text("\x04\x00"
                               "abcd",
                               6, out, sizeof out),
                     ERR_TRUNCATED);
    assert_string_equal(out, "");
    assert_int_equal(read_text("\x03\x00"
                               "a\0c",
                               5, out, sizeof out),
                     ERR_TRUNCATED);
    assert_string_equal(out, "");
    assert_int_equal(read_text("\xff\xff", 2, out, sizeof out), ERR_TRUNCATED);
    assert_int_equal(read_text("\x00\x00", 2, out, 0), ERR_TRUNCATED);
}

TEST(writer_bounds)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    char *text = malloc(65537);
    assert_non_null(text);
    memset(text, 'x', 65536);
    text[65535] = '\0';
    bytes_write_string(&w, text);
    assert_false(w.failed);
    assert_int_equal(w.size_bytes, 65537);
    text[65535] = 'x';
    text[65536] = '\0';
    bytes_write_string(&w, text);
    assert_true(w.failed);
    bytes_write_u8(&w, 1); /* stays failed */
    assert_int_equal(w.size_bytes, 65537);
    free(text);
    bytes_writer_fini(&w);
    assert_null(bytes_extend(&w, SIZE_MAX));
    assert_true(w.failed);
    bytes_writer_init(&w);
    bytes_write_u8(&w, 1);
    assert_null(bytes_extend(&w, SIZE_MAX)); /* the sum overflows */
    assert_true(w.failed);
    bytes_writer_fini(&w);
    bytes_writer_init(&w);
    assert_non_null(bytes_extend(&w, 0));
    bytes_writer_fini(&w);
}

TEST(writer_grows)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    for (uint32_t i = 0; i < 100000; i++) bytes_write_u32(&w, i);
    assert_int_equal(w.size_bytes, 400000);
    struct bytes_reader r;
    bytes_reader_init(&r, w.data, w.size_bytes);
    for (uint32_t i = 0; i < 100000; i++)
        if (bytes_read_u32(&r) != i) fail_msg("value %u differs", i);
    assert_int_equal(bytes_finish(&r), ERR_OK);
    bytes_writer_fini(&w);
}
