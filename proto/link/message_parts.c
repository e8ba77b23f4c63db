#include "proto/link/message_parts.h"

#include <string.h>

#include "proto/error.h"
#include "proto/limits.h"
#include "proto/link/message.h"

/* Bytes of the UTF-8 character at `at` (which ends with a NUL), 0 if it is none or a control
 * character. Unicode 15, table 3-7. */
static size_t character_bytes(const char *at)
{
    const unsigned char *c = (const unsigned char *)at;
    if (c[0] >= 0x20 && c[0] < 0x7f) return 1;
    if (c[0] < 0xc2 || c[0] > 0xf4) return 0;
    unsigned char low = 0x80, high = 0xbf;
    if (c[0] == 0xc2) low = 0xa0; /* below are control characters */
    if (c[0] == 0xe0) low = 0xa0;
    if (c[0] == 0xed) high = 0x9f;
    if (c[0] == 0xf0) low = 0x90;
    if (c[0] == 0xf4) high = 0x8f;
    if (c[1] < low || c[1] > high) return 0;
    size_t size_bytes = c[0] < 0xe0 ? 2 : c[0] < 0xf0 ? 3 : 4;
    for (size_t i = 2; i < size_bytes; i++)
        if ((c[i] & 0xc0) != 0x80) return 0;
    return size_bytes;
}

bool message_text_is_clean(const char *text)
{
    while (*text != '\0') {
        size_t size_bytes = character_bytes(text);
        if (size_bytes == 0) return false;
        text += size_bytes;
    }
    return true;
}

void message_write_text(struct bytes_writer *w, const char *text, size_t capacity)
{
    char clean[LIMIT_DETAIL_BYTES];
    size_t length = strnlen(text, capacity - 1);
    memcpy(clean, text, length);
    clean[length] = '\0';
    for (size_t i = 0; i < length;) {
        size_t size_bytes = character_bytes(clean + i);
        if (size_bytes == 0) clean[i] = '?';
        i += size_bytes != 0 ? size_bytes : 1;
    }
    bytes_write_string(w, clean);
}

void message_write_i32(struct bytes_writer *w, int32_t v)
{
    bytes_write_u32(w, (uint32_t)v);
}

int32_t message_read_i32(struct bytes_reader *r)
{
    return (int32_t)bytes_read_u32(r);
}

void message_write_digest(struct bytes_writer *w, const struct digest *d)
{
    bytes_write_raw(w, d->bytes, DIGEST_BYTES);
}

void message_read_digest(struct bytes_reader *r, struct digest *d)
{
    bytes_read_raw(r, d->bytes, DIGEST_BYTES);
}

int message_read_tail(struct bytes_reader *r, const uint8_t **bytes, uint32_t *size_bytes)
{
    size_t left_bytes = bytes_left(r);
    if (left_bytes > LIMIT_FRAME_BYTES) return ERR_LIMIT;
    *bytes = bytes_borrow(r, left_bytes);
    *size_bytes = (uint32_t)left_bytes;
    return ERR_OK;
}
