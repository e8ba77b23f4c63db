#include "proto/bytes.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

/* Rows of floats are copied as they lie in memory. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the wire is little-endian");

#define FIRST_CAPACITY_BYTES 64u

static const uint8_t nothing[1];

void bytes_reader_init(struct bytes_reader *r, const void *data, size_t size_bytes)
{
    r->at = data != NULL ? data : nothing;
    r->end = r->at + (data != NULL ? size_bytes : 0);
    r->failed = data == NULL && size_bytes != 0;
}

size_t bytes_left(const struct bytes_reader *r)
{
    return r->failed ? 0 : (size_t)(r->end - r->at);
}

const uint8_t *bytes_borrow(struct bytes_reader *r, size_t size_bytes)
{
    if (r->failed || size_bytes > (size_t)(r->end - r->at)) {
        r->failed = true;
        return NULL;
    }
    const uint8_t *at = r->at;
    r->at += size_bytes;
    return at;
}

void bytes_read_raw(struct bytes_reader *r, void *out, size_t size_bytes)
{
    if (size_bytes == 0) return;
    const uint8_t *at = bytes_borrow(r, size_bytes);
    if (at != NULL)
        memcpy(out, at, size_bytes);
    else
        memset(out, 0, size_bytes);
}

uint16_t bytes_read_u16(struct bytes_reader *r)
{
    uint16_t v;
    bytes_read_raw(r, &v, sizeof v);
    return v;
}

uint32_t bytes_read_u32(struct bytes_reader *r)
{
    uint32_t v;
    bytes_read_raw(r, &v, sizeof v);
    return v;
}

uint64_t bytes_read_u64(struct bytes_reader *r)
{
    uint64_t v;
    bytes_read_raw(r, &v, sizeof v);
    return v;
}

float bytes_read_f32(struct bytes_reader *r)
{
    float v;
    bytes_read_raw(r, &v, sizeof v);
    return v;
}

void bytes_read_f32s(struct bytes_reader *r, float *out, size_t count)
{
    if (count > SIZE_MAX / sizeof *out) {
        r->failed = true;
        return;
    }
    bytes_read_raw(r, out, count * sizeof *out);
}

void bytes_read_string(struct bytes_reader *r, char *out, size_t capacity)
{
    size_t length = bytes_read_u16(r);
    if (capacity == 0) {
        r->failed = true;
        return;
    }
    out[0] = '\0';
    if (length >= capacity) {
        r->failed = true;
        return;
    }
    const uint8_t *text = bytes_borrow(r, length);
    if (text == NULL) return;
    if (memchr(text, 0, length) != NULL) {
        r->failed = true;
        return;
    }
    memcpy(out, text, length);
    out[length] = '\0';
}

int bytes_finish(const struct bytes_reader *r)
{
    if (r->failed) return ERR_TRUNCATED;
    return r->at == r->end ? ERR_OK : ERR_TRAILING;
}

void bytes_writer_init(struct bytes_writer *w)
{
    *w = (struct bytes_writer){0};
}

void bytes_writer_fini(struct bytes_writer *w)
{
    free(w->data);
    *w = (struct bytes_writer){0};
}

/* Doubles, so that many small writes cost little. */
static bool writer_grow(struct bytes_writer *w, size_t needed_bytes)
{
    size_t capacity_bytes = w->capacity_bytes;
    if (needed_bytes > PTRDIFF_MAX) return false; /* no object is that large */
    if (capacity_bytes < FIRST_CAPACITY_BYTES) capacity_bytes = FIRST_CAPACITY_BYTES;
    while (capacity_bytes < needed_bytes) capacity_bytes *= 2; /* at most PTRDIFF_MAX + 1 */
    uint8_t *data = realloc(w->data, capacity_bytes);
    if (data == NULL) return false;
    w->data = data;
    w->capacity_bytes = capacity_bytes;
    return true;
}

uint8_t *bytes_extend(struct bytes_writer *w, size_t size_bytes)
{
    if (w->failed) return NULL;
    bool overflows = size_bytes > SIZE_MAX - w->size_bytes;
    bool fits = w->data != NULL && !overflows && w->size_bytes + size_bytes <= w->capacity_bytes;
    if (overflows || (!fits && !writer_grow(w, w->size_bytes + size_bytes))) {
        w->failed = true;
        return NULL;
    }
    uint8_t *at = w->data + w->size_bytes;
    w->size_bytes += size_bytes;
    return at;
}

void bytes_write_raw(struct bytes_writer *w, const void *data, size_t size_bytes)
{
    if (size_bytes == 0) return;
    uint8_t *at = bytes_extend(w, size_bytes);
    if (at != NULL) memcpy(at, data, size_bytes);
}

void bytes_write_u8(struct bytes_writer *w, uint8_t v)
{
    bytes_write_raw(w, &v, sizeof v);
}

void bytes_write_u16(struct bytes_writer *w, uint16_t v)
{
    bytes_write_raw(w, &v, sizeof v);
}

void bytes_write_u32(struct bytes_writer *w, uint32_t v)
{
    bytes_write_raw(w, &v, sizeof v);
}

void bytes_write_u64(struct bytes_writer *w, uint64_t v)
{
    bytes_write_raw(w, &v, sizeof v);
}

void bytes_write_f32(struct bytes_writer *w, float v)
{
    bytes_write_raw(w, &v, sizeof v);
}

void bytes_write_f32s(struct bytes_writer *w, const float *v, size_t count)
{
    if (count > SIZE_MAX / sizeof *v) {
        w->failed = true;
        return;
    }
    bytes_write_raw(w, v, count * sizeof *v);
}

void bytes_write_string(struct bytes_writer *w, const char *text)
{
    size_t length = strlen(text);
    if (length > UINT16_MAX) {
        w->failed = true;
        return;
    }
    bytes_write_u16(w, (uint16_t)length);
    bytes_write_raw(w, text, length);
}
