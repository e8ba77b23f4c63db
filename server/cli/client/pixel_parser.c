#include "server/cli/client/pixel_parser.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "proto/limits.h"

#define HEADER_BYTES 32u
#define MAGIC        "SWPX"
#define F32          2u
#define F32_ALPHA    4u
#define BLOCK_MAX    (1u << 20) /* pixels */

static uint32_t read_u32(const uint8_t *from)
{
    uint32_t v;
    memcpy(&v, from, sizeof v); /* little-endian, as every CPU that Embree runs on here */
    return v;
}

void pixel_parser_fini(struct pixel_parser *p)
{
    free(p->data);
    *p = (struct pixel_parser){.data = NULL};
}

void pixel_parser_restart(struct pixel_parser *p)
{
    p->size_bytes = 0;
    p->error = 0;
}

/* Bytes of the message that the header tells of; 0 for one that is none. */
static size_t message_bytes(const uint8_t *header)
{
    const uint32_t format = header[6] | (uint32_t)header[7] << 8;
    const uint32_t x = read_u32(header + 8), y = read_u32(header + 12);
    const uint32_t w = read_u32(header + 16), h = read_u32(header + 20);
    const uint32_t side = LIMIT_IMAGE_SIDE_PX;
    if (memcmp(header, MAGIC, 4) != 0 || header[4] != 1 || header[5] != 0) return 0;
    if (x > side || y > side) return 0;
    if (w == 0 || h == 0) return w <= side ? HEADER_BYTES : 0; /* h may number a view */
    if (w > side || h > side || (uint64_t)w * h > BLOCK_MAX) return 0;
    if (format != F32 && format != F32_ALPHA) return 0;
    return HEADER_BYTES + (size_t)w * h * (format == F32 ? 3 : 4) * sizeof(float);
}

static int hold(struct pixel_parser *p, const uint8_t *bytes, size_t count)
{
    if (p->size_bytes + count > p->held_bytes) {
        const size_t held = p->size_bytes + count + (1u << 16);
        uint8_t *grown = realloc(p->data, held);
        if (!grown) return ERR_MEMORY;
        p->data = grown;
        p->held_bytes = held;
    }
    memcpy(p->data + p->size_bytes, bytes, count);
    p->size_bytes += count;
    return 0;
}

/* The whole message in hand; its numbers are aligned, since the header has 32 bytes. */
static bool take(const uint8_t *data, pixel_block_taken taken, void *ctx)
{
    const int32_t x = (int32_t)read_u32(data + 8), y = (int32_t)read_u32(data + 12);
    const int32_t w = (int32_t)read_u32(data + 16), h = (int32_t)read_u32(data + 20);
    struct pixel_block block = {.rect = {x, y, x + w, y + h}};
    memcpy(&block.revision, data + 24, sizeof block.revision);
    if (w == 0 || h == 0) {
        if (w == 0) block.view = (uint32_t)h;
        block.rect = (struct rect){0};
        block.width_px = x;
        block.height_px = y;
    } else {
        block.numbers = (const float *)(const void *)(data + HEADER_BYTES);
        block.alpha = data[6] == F32_ALPHA ? block.numbers + (size_t)w * (size_t)h * 3 : NULL;
    }
    return taken(ctx, &block);
}

bool pixel_parser_feed(struct pixel_parser *p, const void *bytes, size_t count,
                       pixel_block_taken taken, void *ctx)
{
    const uint8_t *at = bytes;
    while (count > 0 && !p->error) {
        size_t need = p->size_bytes < HEADER_BYTES ? HEADER_BYTES : message_bytes(p->data);
        if (need == 0) {
            p->error = ERR_CORRUPT;
            break;
        }
        const size_t missing = need - p->size_bytes, n = missing < count ? missing : count;
        p->error = hold(p, at, n);
        at += n;
        count -= n;
        if (p->error || p->size_bytes < HEADER_BYTES) continue;
        if (p->size_bytes != message_bytes(p->data)) continue;
        if (!take(p->data, taken, ctx)) return false;
        p->size_bytes = 0;
    }
    return !p->error;
}
