#pragma once
/* What several messages are made of. For message*.c alone. */
#include <string.h>

#include "proto/bytes.h"
#include "proto/digest.h"

/* Begins to read a payload into message `m`, which is cleared. */
static inline struct bytes_reader message_reader(const void *payload, size_t size_bytes, void *m,
                                                 size_t m_bytes)
{
    struct bytes_reader r;
    bytes_reader_init(&r, payload, size_bytes);
    memset(m, 0, m_bytes);
    return r;
}

/* Writes a cleaned text; `capacity` is at most LIMIT_DETAIL_BYTES. */
void message_write_text(struct bytes_writer *w, const char *text, size_t capacity);

void message_write_i32(struct bytes_writer *w, int32_t v);
int32_t message_read_i32(struct bytes_reader *r);
void message_write_digest(struct bytes_writer *w, const struct digest *d);
void message_read_digest(struct bytes_reader *r, struct digest *d);

/* Reads the rest of the payload, for the two messages that end in a byte range. ERR_LIMIT. */
int message_read_tail(struct bytes_reader *r, const uint8_t **bytes, uint32_t *size_bytes);
