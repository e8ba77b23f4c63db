/* Every message decoder. Input: the message's number as u16, then the payload. What decodes must
 * encode back to the same bytes: then no field is lost, none is read twice, and each payload has
 * one meaning. A tile's counts that unpack must survive being packed. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/count_map.h"
#include "proto/link/message.h"

/* Messages that end in a byte range: encode leaves it to the frame's tail. */
static void write_tail(struct bytes_writer *w, uint16_t number, const void *message)
{
    if (number == MESSAGE_RESULT) {
        const struct message_result *m = message;
        bytes_write_raw(w, m->samples, m->samples_bytes);
    } else if (number == MESSAGE_BLOB_PART) {
        const struct message_blob_part *m = message;
        bytes_write_raw(w, m->bytes, m->size_bytes);
    }
}

static void compare(const struct bytes_writer *w, const uint8_t *payload, size_t size_bytes)
{
    if (w->failed || w->size_bytes != size_bytes) abort();
    if (size_bytes > 0 && memcmp(w->data, payload, size_bytes) != 0) abort();
}

static void unpack_counts(const uint8_t *payload, size_t payload_bytes)
{
    static uint8_t counts[COUNT_MAP_BYTES_MAX], again[COUNT_MAP_BYTES_MAX];
    struct message_tile m;
    struct bytes_writer w;
    if (message_decode_tile(payload, payload_bytes, &m) != ERR_OK || m.counts_bytes == 0) return;
    const int32_t width = rect_width(m.rect), height = rect_height(m.rect);
    for (uint32_t maps = 1; maps <= COUNT_MAPS_MAX; maps++) {
        if (count_map_unpack(m.counts, m.counts_bytes, maps, width, height, counts) != 0) continue;
        bytes_writer_init(&w);
        if (count_map_pack(&w, counts, maps, width, height) != 0 ||
            count_map_unpack(w.data, w.size_bytes, maps, width, height, again) != 0)
            abort();
        if (memcmp(counts, again, maps * (size_t)rect_area(m.rect)) != 0) abort();
        bytes_writer_fini(&w);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct bytes_reader r;
    struct bytes_writer w;
    bytes_reader_init(&r, data, size_bytes);
    uint16_t asked = bytes_read_u16(&r);
    if (r.failed) return 0;
    const uint8_t *payload = r.at;
    size_t payload_bytes = bytes_left(&r);
    bytes_writer_init(&w);
    switch (asked) {
#define MESSAGE(name, number, type, sender, text)                                                  \
    case number: {                                                                                 \
        struct message_##type m;                                                                   \
        if (message_decode_##type(payload, payload_bytes, &m) != ERR_OK) break;                    \
        message_encode_##type(&w, &m);                                                             \
        write_tail(&w, number, &m);                                                                \
        compare(&w, payload, payload_bytes);                                                       \
        break;                                                                                     \
    }
#include "proto/link/message.def"
#undef MESSAGE
    default:
        if (message_name(asked) != NULL) abort();
    }
    bytes_writer_fini(&w);
    if (asked == MESSAGE_TILE) unpack_counts(payload, payload_bytes);
    return 0;
}
