/* The frame decoder and the inbox. Input: a byte that chooses (bit 7: make checksums right, so that
 * what lies behind them is reached; bits 0..6: bytes a read less one), then the stream.
 *
 * Checked: however the stream is cut, the inbox yields the frames and the final code that decoding
 * the whole stream at once yields, and what decodes frames back to the same bytes. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "proto/link/wire_frame.h"

#define LIMIT_BYTES 65536u

static uint32_t u32_at(const uint8_t *data)
{
    uint32_t v;
    memcpy(&v, data, sizeof v);
    return v;
}

/* Gives each frame of the stream the checksum it should have. */
static void repair(uint8_t *stream, size_t size_bytes)
{
    size_t at = 0;
    while (size_bytes - at >= WIRE_FRAME_HEADER_BYTES) {
        uint32_t payload_bytes = u32_at(stream + at + 4);
        if (payload_bytes > size_bytes - at - WIRE_FRAME_HEADER_BYTES) return;
        uint32_t crc = wire_frame_crc32c(0, stream + at + 4, 16);
        crc = wire_frame_crc32c(crc, stream + at + WIRE_FRAME_HEADER_BYTES, payload_bytes);
        memcpy(stream + at + 20, &crc, sizeof crc);
        at += WIRE_FRAME_HEADER_BYTES + payload_bytes;
    }
}

static void check_reframed(const struct wire_frame_view *view, const uint8_t *stream,
                           size_t used_bytes)
{
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    uint32_t head_bytes = view->payload_bytes / 3;
    assert(used_bytes == WIRE_FRAME_HEADER_BYTES + (size_t)view->payload_bytes);
    wire_frame_header(header, view->type, view->request_id, view->payload, head_bytes,
                      view->payload + head_bytes, view->payload_bytes - head_bytes);
    assert(memcmp(header, stream, sizeof header) == 0);
}

/* Feeds pieces; returns the last code, with the frames' bytes counted in *taken_bytes. */
static int through_inbox(const uint8_t *stream, size_t size_bytes, size_t piece_bytes,
                         size_t *taken_bytes)
{
    struct wire_frame_inbox in;
    struct wire_frame_view view;
    int code = ERR_INCOMPLETE;
    *taken_bytes = 0;
    wire_frame_inbox_init(&in, LIMIT_BYTES);
    for (size_t at = 0; at < size_bytes && code == ERR_INCOMPLETE;) {
        size_t space_bytes, left = size_bytes - at;
        uint8_t *space = wire_frame_inbox_space(&in, &space_bytes);
        if (space == NULL) abort();
        size_t now = piece_bytes < left ? piece_bytes : left;
        if (now > space_bytes) now = space_bytes;
        memcpy(space, stream + at, now);
        wire_frame_inbox_filled(&in, now);
        at += now;
        while ((code = wire_frame_inbox_next(&in, &view)) == ERR_OK) {
            assert(memcmp(view.payload, stream + *taken_bytes + WIRE_FRAME_HEADER_BYTES,
                          view.payload_bytes) == 0);
            *taken_bytes += WIRE_FRAME_HEADER_BYTES + (size_t)view.payload_bytes;
        }
        assert(in.capacity_bytes <= 2 * LIMIT_BYTES + WIRE_FRAME_HEADER_BYTES + 8192);
    }
    wire_frame_inbox_fini(&in);
    return code;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    if (size_bytes < 2) return 0;
    size_t stream_bytes = size_bytes - 1, at = 0, used_bytes = 0, taken_bytes;
    uint8_t *stream = malloc(stream_bytes);
    if (stream == NULL) return 0;
    memcpy(stream, data + 1, stream_bytes);
    if (data[0] & 0x80) repair(stream, stream_bytes);

    struct wire_frame_view view;
    int code = ERR_INCOMPLETE;
    while (at < stream_bytes) {
        code = wire_frame_decode(stream + at, stream_bytes - at, LIMIT_BYTES, &view, &used_bytes);
        if (code != ERR_OK) break;
        check_reframed(&view, stream + at, used_bytes);
        at += used_bytes;
        code = ERR_INCOMPLETE;
    }
    if (code == ERR_INCOMPLETE && at < stream_bytes) assert(used_bytes > stream_bytes - at);

    int same = through_inbox(stream, stream_bytes, (size_t)(data[0] & 0x7f) + 1, &taken_bytes);
    assert(same == code);
    assert(taken_bytes == at);
    free(stream);
    return 0;
}
