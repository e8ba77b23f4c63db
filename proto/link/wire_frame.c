#include "proto/link/wire_frame.h"

#include <assert.h>
#include <isa-l/crc.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "proto/bytes.h"
#include "proto/error.h"

#define CRC_PIECE_BYTES     (1u << 30) /* the library counts in int */
#define SPACE_BYTES         4096u      /* least room that a read gets */
#define CAPACITY_KEPT_BYTES (4u << 20) /* an empty inbox gives back what is above */
#define CHECKED_FROM        4u         /* the checksum covers the header from here ... */
#define CHECKED_BYTES       16u        /* ... for so many bytes, and the payload */

/* The library leaves the inversions before and after to its caller. */
uint32_t wire_frame_crc32c(uint32_t crc, const void *data, size_t size_bytes)
{
    /* Not written to: the library's declaration lacks a const. */
    unsigned char *at = (unsigned char *)(uintptr_t)data;
    crc = ~crc;
    while (size_bytes > 0) {
        size_t piece_bytes = size_bytes < CRC_PIECE_BYTES ? size_bytes : CRC_PIECE_BYTES;
        crc = crc32_iscsi(at, (int)piece_bytes, crc);
        at += piece_bytes;
        size_bytes -= piece_bytes;
    }
    return ~crc;
}

static int incomplete(size_t enough_bytes, size_t *used_bytes)
{
    *used_bytes = enough_bytes;
    return ERR_INCOMPLETE;
}

int wire_frame_decode(const uint8_t *data, size_t size_bytes, uint32_t limit_bytes,
                      struct wire_frame_view *out, size_t *used_bytes)
{
    static const uint32_t magic = WIRE_FRAME_MAGIC;
    size_t magic_bytes = size_bytes < sizeof magic ? size_bytes : sizeof magic;
    *used_bytes = 0;
    if (magic_bytes > 0 && memcmp(data, &magic, magic_bytes) != 0) return ERR_MAGIC;
    if (size_bytes < WIRE_FRAME_HEADER_BYTES)
        return incomplete(WIRE_FRAME_HEADER_BYTES, used_bytes);

    struct bytes_reader r;
    bytes_reader_init(&r, data + CHECKED_FROM, WIRE_FRAME_HEADER_BYTES - CHECKED_FROM);
    uint32_t payload_bytes = bytes_read_u32(&r);
    uint16_t type = bytes_read_u16(&r);
    uint16_t flags = bytes_read_u16(&r);
    uint64_t request_id = bytes_read_u64(&r);
    uint32_t checksum = bytes_read_u32(&r);
    if (payload_bytes > limit_bytes) return ERR_LIMIT;
    if (flags != 0) return ERR_RANGE;

    size_t whole_bytes = (size_t)WIRE_FRAME_HEADER_BYTES + payload_bytes;
    if (size_bytes < whole_bytes) return incomplete(whole_bytes, used_bytes);
    const uint8_t *payload = data + WIRE_FRAME_HEADER_BYTES;
    uint32_t crc = wire_frame_crc32c(0, data + CHECKED_FROM, CHECKED_BYTES);
    if (wire_frame_crc32c(crc, payload, payload_bytes) != checksum) return ERR_CHECKSUM;

    *out = (struct wire_frame_view){type, request_id, payload, payload_bytes};
    *used_bytes = whole_bytes;
    return ERR_OK;
}

void wire_frame_header(uint8_t out[WIRE_FRAME_HEADER_BYTES], uint16_t type, uint64_t request_id,
                       const void *head, uint32_t head_bytes, const void *tail, uint32_t tail_bytes)
{
    assert(head_bytes <= UINT32_MAX - tail_bytes);
    const uint32_t magic = WIRE_FRAME_MAGIC, payload_bytes = head_bytes + tail_bytes;
    const uint16_t flags = 0;
    memcpy(out, &magic, 4);
    memcpy(out + 4, &payload_bytes, 4);
    memcpy(out + 8, &type, 2);
    memcpy(out + 10, &flags, 2);
    memcpy(out + 12, &request_id, 8);
    uint32_t crc = wire_frame_crc32c(0, out + CHECKED_FROM, CHECKED_BYTES);
    crc = wire_frame_crc32c(crc, head, head_bytes);
    crc = wire_frame_crc32c(crc, tail, tail_bytes);
    memcpy(out + 20, &crc, 4);
}

void wire_frame_inbox_init(struct wire_frame_inbox *in, uint32_t limit_bytes)
{
    *in = (struct wire_frame_inbox){.limit_bytes = limit_bytes};
}

void wire_frame_inbox_fini(struct wire_frame_inbox *in)
{
    free(in->data);
    *in = (struct wire_frame_inbox){0};
}

/* Moves what is pending to the front. An empty inbox that a large frame has grown shrinks again. */
static void inbox_compact(struct wire_frame_inbox *in)
{
    size_t pending_bytes = in->end - in->start;
    if (pending_bytes == 0 && in->capacity_bytes > CAPACITY_KEPT_BYTES) {
        free(in->data);
        in->data = NULL;
        in->capacity_bytes = 0;
    } else if (pending_bytes > 0 && in->start > 0) {
        memmove(in->data, in->data + in->start, pending_bytes);
    }
    in->start = 0;
    in->end = pending_bytes;
}

/* Doubles as bytes really arrive: a peer that merely announces a large frame costs nothing. */
static int inbox_grow(struct wire_frame_inbox *in)
{
    size_t most_bytes = (size_t)in->limit_bytes + WIRE_FRAME_HEADER_BYTES;
    size_t capacity_bytes = in->capacity_bytes * 2;
    if (capacity_bytes > most_bytes) capacity_bytes = most_bytes;
    /* What arrived whole and is not decoded yet may fill the bound: a read still gets its room. */
    if (capacity_bytes < in->end + SPACE_BYTES) capacity_bytes = in->end + SPACE_BYTES;
    uint8_t *data = realloc(in->data, capacity_bytes);
    if (data == NULL) return ERR_MEMORY;
    in->data = data;
    in->capacity_bytes = capacity_bytes;
    return ERR_OK;
}

uint8_t *wire_frame_inbox_space(struct wire_frame_inbox *in, size_t *space_bytes)
{
    *space_bytes = 0;
    bool empty = in->start == in->end;
    if (empty || in->capacity_bytes - in->end < SPACE_BYTES) inbox_compact(in);
    if (in->capacity_bytes - in->end < SPACE_BYTES && inbox_grow(in) != ERR_OK) return NULL;
    *space_bytes = in->capacity_bytes - in->end;
    return in->data + in->end;
}

void wire_frame_inbox_filled(struct wire_frame_inbox *in, size_t size_bytes)
{
    assert(size_bytes <= in->capacity_bytes - in->end);
    in->end += size_bytes;
}

int wire_frame_inbox_next(struct wire_frame_inbox *in, struct wire_frame_view *out)
{
    size_t used_bytes;
    if (in->start == in->end) return ERR_INCOMPLETE;
    int code = wire_frame_decode(in->data + in->start, in->end - in->start, in->limit_bytes, out,
                                 &used_bytes);
    if (code == ERR_OK) in->start += used_bytes;
    return code;
}
