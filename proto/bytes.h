#pragma once
/* Bounds-checked little-endian reading and writing.
 *
 * A reader that once failed stays failed and yields zeros, so that a decoder may read a whole
 * struct and ask once at the end. A writer grows its buffer; after a failed allocation it stays
 * failed likewise. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct bytes_reader {
    const uint8_t *at;
    const uint8_t *end;
    bool failed;
};

void bytes_reader_init(struct bytes_reader *r, const void *data, size_t size_bytes);
size_t bytes_left(const struct bytes_reader *r);
uint16_t bytes_read_u16(struct bytes_reader *r);
uint32_t bytes_read_u32(struct bytes_reader *r);
uint64_t bytes_read_u64(struct bytes_reader *r);
float bytes_read_f32(struct bytes_reader *r);
void bytes_read_f32s(struct bytes_reader *r, float *out, size_t count);

/* Borrows `size_bytes` bytes of the input; NULL (and failed) when there are fewer. */
const uint8_t *bytes_borrow(struct bytes_reader *r, size_t size_bytes);

void bytes_read_raw(struct bytes_reader *r, void *out, size_t size_bytes);

/* Reads a u16 length and that many bytes into out, terminated. Fails when the length reaches
 * `capacity` or the text holds a NUL byte. */
void bytes_read_string(struct bytes_reader *r, char *out, size_t capacity);

/* Returns 0 when everything was read, ERR_TRUNCATED when the reader failed, ERR_TRAILING when bytes
 * are left. */
int bytes_finish(const struct bytes_reader *r);

struct bytes_writer {
    uint8_t *data; /* owned; NULL while empty */
    size_t size_bytes;
    size_t capacity_bytes;
    bool failed;
};

void bytes_writer_init(struct bytes_writer *w);
void bytes_writer_fini(struct bytes_writer *w);

/* Makes room for `size_bytes` more and returns where they go, counted as written; NULL on a failed
 * allocation. The pointer holds until the next write. */
uint8_t *bytes_extend(struct bytes_writer *w, size_t size_bytes);
void bytes_write_u8(struct bytes_writer *w, uint8_t v);
void bytes_write_u16(struct bytes_writer *w, uint16_t v);
void bytes_write_u32(struct bytes_writer *w, uint32_t v);
void bytes_write_u64(struct bytes_writer *w, uint64_t v);
void bytes_write_f32(struct bytes_writer *w, float v);
void bytes_write_f32s(struct bytes_writer *w, const float *v, size_t count);
void bytes_write_raw(struct bytes_writer *w, const void *data, size_t size_bytes);

/* Writes a u16 length and the bytes. Fails above 65535. */
void bytes_write_string(struct bytes_writer *w, const char *text);
