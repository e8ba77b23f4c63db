/* Every message decoder. Input: the message's number as u16, then the payload. What decodes must
 * encode back to the same bytes: then no field is lost, none is read twice, and each payload has
 * one meaning. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/message.h"

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
#include "proto/message.def"
#undef MESSAGE
    default:
        if (message_name(asked) != NULL) abort();
    }
    bytes_writer_fini(&w);
    return 0;
}
