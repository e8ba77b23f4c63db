#pragma once
/* Framing of worker links: a fixed header, then a payload. Decoding does no IO and no allocation.
 *
 *   offset size
 *        0    4  magic "SHWR"
 *        4    4  payload length in bytes
 *        8    2  message type
 *       10    2  flags, 0
 *       12    8  request id: an answer has its question's
 *       20    4  CRC32C of bytes 4..19 and the payload
 *
 * Numbers are little-endian. The length is checked against the limit before the payload is read. */
#include <stddef.h>
#include <stdint.h>

#define WIRE_FRAME_HEADER_BYTES 24u
#define WIRE_FRAME_MAGIC        0x52574853u /* "SHWR" */

struct wire_frame_view {
    uint16_t type;
    uint64_t request_id;
    const uint8_t *payload; /* borrowed from the input */
    uint32_t payload_bytes;
};

/* Decodes one frame of *used_bytes from the start of `data`. `limit_bytes` caps the payload.
 * ERR_INCOMPLETE when more bytes are needed, *used_bytes in all; ERR_MAGIC, ERR_LIMIT, ERR_RANGE
 * (flags), ERR_CHECKSUM. */
int wire_frame_decode(const uint8_t *data, size_t size_bytes, uint32_t limit_bytes,
                      struct wire_frame_view *out, size_t *used_bytes);

/* Writes the header for a payload that consists of `head` and then `tail` (either may be empty), so
 * that a large tail need not be copied. */
void wire_frame_header(uint8_t out[WIRE_FRAME_HEADER_BYTES], uint16_t type, uint64_t request_id,
                       const void *head, uint32_t head_bytes, const void *tail,
                       uint32_t tail_bytes);

uint32_t wire_frame_crc32c(uint32_t crc, const void *data, size_t size_bytes);

/* Received bytes that are not yet decoded: a growing buffer, bounded by limit + header. */
struct wire_frame_inbox {
    uint8_t *data; /* owned */
    size_t start, end, capacity_bytes;
    uint32_t limit_bytes;
};

void wire_frame_inbox_init(struct wire_frame_inbox *in, uint32_t limit_bytes);
void wire_frame_inbox_fini(struct wire_frame_inbox *in);

/* Returns where to read more bytes to, at least 4 KiB. NULL on failed allocation. */
uint8_t *wire_frame_inbox_space(struct wire_frame_inbox *in, size_t *space_bytes);
void wire_frame_inbox_filled(struct wire_frame_inbox *in, size_t size_bytes);

/* Returns the next whole frame in *out. ERR_INCOMPLETE, or what wire_frame_decode returns. The view
 * is valid until the next call on this inbox. */
int wire_frame_inbox_next(struct wire_frame_inbox *in, struct wire_frame_view *out);
