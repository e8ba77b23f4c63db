/* Frames: checksum, splits at every byte, damage of every bit, limits before payloads, the inbox.
 */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "proto/limits.h"
#include "proto/link/wire_frame.h"
#include "tests/unit/unit.h"

#define PAYLOAD       "the payload of a frame"
#define PAYLOAD_BYTES (sizeof PAYLOAD - 1)
#define WHOLE_BYTES   (WIRE_FRAME_HEADER_BYTES + PAYLOAD_BYTES)

static void make_frame(uint8_t out[WHOLE_BYTES])
{
    wire_frame_header(out, 7, 0x0123456789abcdefull, PAYLOAD, PAYLOAD_BYTES, NULL, 0);
    memcpy(out + WIRE_FRAME_HEADER_BYTES, PAYLOAD, PAYLOAD_BYTES);
}

/* RFC 3720, appendix B.4, and the usual check value. */
TEST(checksum_is_crc32c)
{
    uint8_t data[32];
    assert_int_equal(wire_frame_crc32c(0, "123456789", 9), 0xe3069283u);
    assert_int_equal(wire_frame_crc32c(0, NULL, 0), 0);
    memset(data, 0, sizeof data);
    assert_int_equal(wire_frame_crc32c(0, data, sizeof data), 0x8a9136aau);
    memset(data, 0xff, sizeof data);
    assert_int_equal(wire_frame_crc32c(0, data, sizeof data), 0x62a8ab43u);
    for (size_t i = 0; i < sizeof data; i++) data[i] = (uint8_t)i;
    assert_int_equal(wire_frame_crc32c(0, data, sizeof data), 0x46dd794eu);
    for (size_t cut = 0; cut <= 9; cut++) {
        uint32_t crc = wire_frame_crc32c(0, "123456789", cut);
        assert_int_equal(wire_frame_crc32c(crc, &"123456789"[cut], 9 - cut), 0xe3069283u);
    }
}

/* The layout of the header's comment, byte by byte. */
TEST(header_is_as_documented)
{
    static const uint8_t expected[20] = {'S',  'H',  'W',  'R', PAYLOAD_BYTES, 0,    0,    0,
                                         7,    0,    0,    0,   0xef,          0xcd, 0xab, 0x89,
                                         0x67, 0x45, 0x23, 0x01};
    uint8_t frame[WHOLE_BYTES];
    make_frame(frame);
    assert_memory_equal(frame, expected, sizeof expected);
    uint32_t crc = wire_frame_crc32c(0, frame + 4, 16);
    crc = wire_frame_crc32c(crc, PAYLOAD, PAYLOAD_BYTES);
    uint8_t stored[4] = {(uint8_t)crc, (uint8_t)(crc >> 8), (uint8_t)(crc >> 16),
                         (uint8_t)(crc >> 24)};
    assert_memory_equal(frame + 20, stored, 4);
}

TEST(decodes_what_was_framed)
{
    uint8_t frame[WHOLE_BYTES + 3] = {0};
    struct wire_frame_view view;
    size_t used_bytes;
    make_frame(frame);
    assert_int_equal(wire_frame_decode(frame, sizeof frame, 100, &view, &used_bytes), ERR_OK);
    assert_int_equal(used_bytes, WHOLE_BYTES); /* what follows is the next frame's */
    assert_int_equal(view.type, 7);
    assert_true(view.request_id == 0x0123456789abcdefull);
    assert_int_equal(view.payload_bytes, PAYLOAD_BYTES);
    assert_ptr_equal(view.payload, frame + WIRE_FRAME_HEADER_BYTES);
}

TEST(head_and_tail_are_one_payload)
{
    uint8_t whole[WHOLE_BYTES], split[WIRE_FRAME_HEADER_BYTES];
    make_frame(whole);
    for (uint32_t cut = 0; cut <= PAYLOAD_BYTES; cut++) {
        wire_frame_header(split, 7, 0x0123456789abcdefull, PAYLOAD, cut, &PAYLOAD[cut],
                          (uint32_t)PAYLOAD_BYTES - cut);
        assert_memory_equal(split, whole, WIRE_FRAME_HEADER_BYTES);
    }
}

TEST(empty_payload)
{
    uint8_t frame[WIRE_FRAME_HEADER_BYTES];
    struct wire_frame_view view;
    size_t used_bytes;
    wire_frame_header(frame, 16, 0, NULL, 0, NULL, 0);
    assert_int_equal(wire_frame_decode(frame, sizeof frame, 0, &view, &used_bytes), ERR_OK);
    assert_int_equal(view.payload_bytes, 0);
    assert_int_equal(used_bytes, WIRE_FRAME_HEADER_BYTES);
}

TEST(every_split_is_incomplete)
{
    uint8_t frame[WHOLE_BYTES];
    make_frame(frame);
    for (size_t size_bytes = 0; size_bytes < WHOLE_BYTES; size_bytes++) {
        uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
        struct wire_frame_view view;
        size_t enough_bytes = 0;
        assert_non_null(exact);
        memcpy(exact, frame, size_bytes);
        assert_int_equal(wire_frame_decode(exact, size_bytes, 100, &view, &enough_bytes),
                         ERR_INCOMPLETE);
        assert_int_equal(enough_bytes, size_bytes < WIRE_FRAME_HEADER_BYTES
                                           ? WIRE_FRAME_HEADER_BYTES
                                           : WHOLE_BYTES);
        free(exact);
    }
}

TEST(every_flipped_bit_is_noticed)
{
    uint8_t frame[WHOLE_BYTES];
    make_frame(frame);
    for (size_t bit = 0; bit < 8 * WHOLE_BYTES; bit++) {
        struct wire_frame_view view;
        size_t used_bytes;
        frame[bit / 8] ^= (uint8_t)(1u << bit % 8);
        int code = wire_frame_decode(frame, sizeof frame, PAYLOAD_BYTES, &view, &used_bytes);
        if (code == ERR_OK || code == ERR_INCOMPLETE)
            fail_msg("bit %zu flipped gives %s", bit, error_name(code));
        if (bit < 32) assert_int_equal(code, ERR_MAGIC);
        if (bit >= 80 && bit < 96) assert_int_equal(code, ERR_RANGE);
        frame[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
}

TEST(wrong_magic_is_refused_at_once)
{
    struct wire_frame_view view;
    size_t used_bytes;
    assert_int_equal(wire_frame_decode((const uint8_t *)"G", 1, 100, &view, &used_bytes),
                     ERR_MAGIC);
    assert_int_equal(wire_frame_decode((const uint8_t *)"SHX", 3, 100, &view, &used_bytes),
                     ERR_MAGIC);
    assert_int_equal(wire_frame_decode((const uint8_t *)"SHW", 3, 100, &view, &used_bytes),
                     ERR_INCOMPLETE);
}

/* From the header alone: no byte of the payload has come yet. */
TEST(limit_is_checked_before_the_payload)
{
    uint8_t frame[WHOLE_BYTES];
    struct wire_frame_view view;
    size_t used_bytes;
    make_frame(frame);
    assert_int_equal(
        wire_frame_decode(frame, WIRE_FRAME_HEADER_BYTES, PAYLOAD_BYTES - 1, &view, &used_bytes),
        ERR_LIMIT);
    assert_int_equal(
        wire_frame_decode(frame, WIRE_FRAME_HEADER_BYTES, PAYLOAD_BYTES, &view, &used_bytes),
        ERR_INCOMPLETE);
    memset(frame + 4, 0xff, 4);
    assert_int_equal(
        wire_frame_decode(frame, WIRE_FRAME_HEADER_BYTES, LIMIT_FRAME_BYTES, &view, &used_bytes),
        ERR_LIMIT);
}

static void feed(struct wire_frame_inbox *in, const void *data, size_t size_bytes)
{
    const uint8_t *from = data;
    while (size_bytes > 0) {
        size_t space_bytes;
        uint8_t *at = wire_frame_inbox_space(in, &space_bytes);
        assert_non_null(at);
        assert_true(space_bytes >= 4096);
        size_t now = size_bytes < space_bytes ? size_bytes : space_bytes;
        memcpy(at, from, now);
        wire_frame_inbox_filled(in, now);
        from += now;
        size_bytes -= now;
    }
}

TEST(inbox_takes_single_bytes)
{
    uint8_t frame[WHOLE_BYTES];
    struct wire_frame_inbox in;
    struct wire_frame_view view;
    make_frame(frame);
    wire_frame_inbox_init(&in, 100);
    for (int round = 0; round < 500; round++) { /* more than its first room: it must compact */
        for (size_t i = 0; i < WHOLE_BYTES; i++) {
            assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_INCOMPLETE);
            feed(&in, frame + i, 1);
        }
        assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_OK);
        assert_int_equal(view.payload_bytes, PAYLOAD_BYTES);
        assert_memory_equal(view.payload, PAYLOAD, PAYLOAD_BYTES);
    }
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_INCOMPLETE);
    assert_true(in.capacity_bytes <= 2 * 4096 + 200);
    wire_frame_inbox_fini(&in);
    assert_null(in.data);
}

/* Frame k has type k and k * 7 payload bytes. */
static size_t make_stream(uint8_t *out, unsigned frames)
{
    size_t at = 0;
    for (unsigned k = 0; k < frames; k++) {
        uint8_t *payload = out + at + WIRE_FRAME_HEADER_BYTES;
        for (unsigned i = 0; i < k * 7; i++) payload[i] = (uint8_t)(k + i);
        wire_frame_header(out + at, (uint16_t)k, k, payload, k * 7, NULL, 0);
        at += WIRE_FRAME_HEADER_BYTES + k * 7;
    }
    return at;
}

TEST(inbox_takes_any_pieces)
{
    enum { FRAMES = 60 };
    uint8_t *stream = malloc(FRAMES * (WIRE_FRAME_HEADER_BYTES + FRAMES * 7));
    assert_non_null(stream);
    size_t stream_bytes = make_stream(stream, FRAMES);
    for (size_t piece_bytes = 1; piece_bytes < stream_bytes; piece_bytes = piece_bytes * 2 + 3) {
        struct wire_frame_inbox in;
        struct wire_frame_view view;
        unsigned got = 0;
        wire_frame_inbox_init(&in, FRAMES * 7);
        for (size_t at = 0; at < stream_bytes; at += piece_bytes) {
            size_t left = stream_bytes - at;
            feed(&in, stream + at, piece_bytes < left ? piece_bytes : left);
            int code;
            while ((code = wire_frame_inbox_next(&in, &view)) == ERR_OK) {
                assert_int_equal(view.type, got);
                assert_int_equal(view.payload_bytes, got * 7);
                for (unsigned i = 0; i < got * 7; i++)
                    if (view.payload[i] != (uint8_t)(got + i)) fail_msg("frame %u differs", got);
                got++;
            }
            assert_int_equal(code, ERR_INCOMPLETE);
        }
        assert_int_equal(got, FRAMES);
        wire_frame_inbox_fini(&in);
    }
    free(stream);
}

TEST(inbox_grows_with_what_comes)
{
    const uint32_t large_bytes = 10u << 20;
    uint8_t *payload = malloc(large_bytes);
    uint8_t header[WIRE_FRAME_HEADER_BYTES], small[WHOLE_BYTES];
    struct wire_frame_inbox in;
    struct wire_frame_view view;
    size_t space_bytes;
    assert_non_null(payload);
    for (uint32_t i = 0; i < large_bytes; i++) payload[i] = (uint8_t)(i * 31);
    wire_frame_header(header, 1, 2, payload, large_bytes, NULL, 0);
    wire_frame_inbox_init(&in, large_bytes);
    feed(&in, header, sizeof header);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_INCOMPLETE);
    assert_non_null(wire_frame_inbox_space(&in, &space_bytes));
    assert_true(in.capacity_bytes < 65536); /* announced is not arrived */
    feed(&in, payload, large_bytes);
    assert_true(in.capacity_bytes <= large_bytes + WIRE_FRAME_HEADER_BYTES + 4096);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_OK);
    assert_int_equal(view.payload_bytes, large_bytes);
    assert_memory_equal(view.payload, payload, large_bytes);
    make_frame(small);
    feed(&in, small, sizeof small); /* empty by now: the large buffer goes back */
    assert_true(in.capacity_bytes < 65536);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_OK);
    assert_memory_equal(view.payload, PAYLOAD, PAYLOAD_BYTES);
    wire_frame_inbox_fini(&in);
    free(payload);
}

TEST(inbox_refuses_what_frames_refuse)
{
    uint8_t frame[WHOLE_BYTES];
    struct wire_frame_inbox in;
    struct wire_frame_view view;
    make_frame(frame);
    wire_frame_inbox_init(&in, PAYLOAD_BYTES - 1);
    feed(&in, frame, WIRE_FRAME_HEADER_BYTES);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_LIMIT);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_LIMIT);
    wire_frame_inbox_fini(&in);
    wire_frame_inbox_init(&in, 100);
    frame[WHOLE_BYTES - 1] ^= 1;
    feed(&in, frame, WHOLE_BYTES);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_CHECKSUM);
    wire_frame_inbox_fini(&in);
    wire_frame_inbox_init(&in, 100);
    feed(&in, "GET / HTTP/1.1\r\n", 16);
    assert_int_equal(wire_frame_inbox_next(&in, &view), ERR_MAGIC);
    wire_frame_inbox_fini(&in);
}
