#include "server/stream/pixels.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "proto/half.h"

static size_t word_count(const struct pixel_blocks *b)
{
    return ((size_t)b->columns * (size_t)b->rows + 63) / 64;
}

int pixel_blocks_init(struct pixel_blocks *b, int32_t width_px, int32_t height_px)
{
    *b = (struct pixel_blocks){.width_px = width_px, .height_px = height_px};
    if (width_px <= 0 || height_px <= 0) return 0;
    b->columns = (width_px + PIXELS_BLOCK_PX - 1) / PIXELS_BLOCK_PX;
    b->rows = (height_px + PIXELS_BLOCK_PX - 1) / PIXELS_BLOCK_PX;
    b->bits = calloc(word_count(b), sizeof *b->bits);
    return b->bits ? 0 : ERR_MEMORY;
}

void pixel_blocks_fini(struct pixel_blocks *b)
{
    free(b->bits);
    *b = (struct pixel_blocks){0};
}

static void set(struct pixel_blocks *b, uint32_t index)
{
    uint64_t bit = UINT64_C(1) << (index % 64);
    if (!(b->bits[index / 64] & bit)) b->count++;
    b->bits[index / 64] |= bit;
}

/* The blocks that a rectangle touches, as a rectangle of blocks. */
static struct rect blocks_of(struct rect changed, int32_t width_px, int32_t height_px)
{
    struct rect r = rect_intersect(changed, (struct rect){0, 0, width_px, height_px});
    if (rect_is_empty(r)) return (struct rect){0};
    return (struct rect){r.x0 / PIXELS_BLOCK_PX, r.y0 / PIXELS_BLOCK_PX,
                         (r.x1 - 1) / PIXELS_BLOCK_PX + 1, (r.y1 - 1) / PIXELS_BLOCK_PX + 1};
}

void pixel_blocks_mark(struct pixel_blocks *b, struct rect changed)
{
    struct rect r = blocks_of(changed, b->width_px, b->height_px);
    if (!b->bits) return;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++) set(b, (uint32_t)(y * b->columns + x));
}

bool pixel_blocks_has(const struct pixel_blocks *b, uint32_t index)
{
    return (b->bits[index / 64] >> (index % 64) & 1) != 0;
}

void pixel_blocks_add(struct pixel_blocks *b, const struct pixel_blocks *more)
{
    const uint32_t total = (uint32_t)b->columns * (uint32_t)b->rows;
    if (!b->bits || !more->bits || b->columns != more->columns || b->rows != more->rows) return;
    for (uint32_t i = 0; i < total; i++)
        if (pixel_blocks_has(more, i)) set(b, i);
}

int pixel_changes_init(struct pixel_changes *c, int32_t width_px, int32_t height_px)
{
    *c = (struct pixel_changes){.width_px = width_px, .height_px = height_px};
    struct rect all = blocks_of((struct rect){0, 0, width_px, height_px}, width_px, height_px);
    const size_t count = (size_t)rect_area(all);
    if (count == 0) return 0;
    c->revision = calloc(count, sizeof *c->revision);
    return c->revision ? 0 : ERR_MEMORY;
}

void pixel_changes_fini(struct pixel_changes *c)
{
    free(c->revision);
    *c = (struct pixel_changes){0};
}

void pixel_changes_mark(struct pixel_changes *c, struct rect changed, uint64_t revision)
{
    struct rect r = blocks_of(changed, c->width_px, c->height_px);
    int32_t columns = (c->width_px + PIXELS_BLOCK_PX - 1) / PIXELS_BLOCK_PX;
    if (!c->revision) return;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++) c->revision[y * columns + x] = revision;
}

uint32_t pixel_changes_block(const struct pixel_changes *c, int32_t x, int32_t y, uint32_t *count)
{
    const int32_t columns = (c->width_px + PIXELS_BLOCK_PX - 1) / PIXELS_BLOCK_PX;
    const int32_t rows = (c->height_px + PIXELS_BLOCK_PX - 1) / PIXELS_BLOCK_PX;
    *count = (uint32_t)(columns * rows);
    return (uint32_t)(y / PIXELS_BLOCK_PX * columns + x / PIXELS_BLOCK_PX);
}

void pixel_blocks_join(struct pixel_blocks *b, const struct pixel_changes *from, uint64_t after)
{
    if (!b->bits || !from->revision || b->width_px != from->width_px ||
        b->height_px != from->height_px)
        return;
    for (uint32_t i = 0; i < (uint32_t)b->columns * (uint32_t)b->rows; i++)
        if (from->revision[i] > after) set(b, i);
}

bool pixel_blocks_take(struct pixel_blocks *b, struct rect *block)
{
    if (b->count == 0) return false;
    uint32_t total = (uint32_t)b->columns * (uint32_t)b->rows;
    uint32_t index = b->next < total ? b->next : 0;
    for (;; index = index + 1 < total ? index + 1 : 0) {
        uint64_t word = b->bits[index / 64] >> (index % 64);
        if (word & 1) break;
        if (word == 0) /* on to the last bit of the word; the loop steps over it */
            index = (index | 63) < total ? (index | 63) : total - 1;
    }
    b->bits[index / 64] &= ~(UINT64_C(1) << (index % 64));
    b->count--;
    b->next = index + 1;
    int32_t x = (int32_t)(index % (uint32_t)b->columns) * PIXELS_BLOCK_PX;
    int32_t y = (int32_t)(index / (uint32_t)b->columns) * PIXELS_BLOCK_PX;
    *block = rect_intersect((struct rect){x, y, x + PIXELS_BLOCK_PX, y + PIXELS_BLOCK_PX},
                            (struct rect){0, 0, b->width_px, b->height_px});
    return true;
}

static uint8_t *put(uint8_t *out, uint64_t v, int bytes)
{
    for (int i = 0; i < bytes; i++) *out++ = (uint8_t)(v >> (8 * i));
    return out;
}

static void write_header(uint8_t *out, enum pixels_format format, uint32_t x, uint32_t y,
                         uint32_t w, uint32_t h, uint64_t revision)
{
    out = put(out, PIXELS_MAGIC, 4);
    out = put(out, PIXELS_VERSION, 2);
    out = put(out, format, 2);
    out = put(out, x, 4);
    out = put(out, y, 4);
    out = put(out, w, 4);
    out = put(out, h, 4);
    put(out, revision, 8);
}

void pixels_set_revision(uint8_t header[PIXELS_HEADER_BYTES], uint64_t revision)
{
    put(header + PIXELS_HEADER_BYTES - 8, revision, 8);
}

void pixels_write_size(uint8_t out[PIXELS_HEADER_BYTES], int32_t width_px, int32_t height_px,
                       uint64_t revision)
{
    write_header(out, PIXELS_F16, (uint32_t)width_px, (uint32_t)height_px, 0, 0, revision);
}

void pixels_write_view(uint8_t out[PIXELS_HEADER_BYTES], uint32_t number, int32_t width_px,
                       int32_t height_px, uint64_t revision)
{
    write_header(out, PIXELS_F16, (uint32_t)width_px, (uint32_t)height_px, 0, number, revision);
}

/* The layer's alpha; NULL without, or where all of the block is opaque. */
static const struct plane *alpha_of(const struct image *image, const char *layer, struct rect block)
{
    const struct plane *alpha = strcmp(layer, "beauty") == 0 ? image_plane(image, "A") : NULL;
    for (int32_t y = block.y0; alpha && y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++)
            if (*plane_at(alpha, x, y) != 1.0f) return alpha;
    return NULL;
}

/* Little-endian, as every CPU that Embree runs on here. */
static uint8_t *put_numbers(uint8_t *out, const float *numbers, size_t count, bool half)
{
    uint16_t halves[PIXELS_BLOCK_PX * 3];
    const size_t bytes = count * (half ? sizeof *halves : sizeof *numbers);
    if (half) half_from_floats(numbers, halves, count);
    memcpy(out, half ? (const void *)halves : numbers, bytes);
    return out + bytes;
}

size_t pixels_write_block(uint8_t out[PIXELS_MESSAGE_BYTES], const struct image *image,
                          const char *layer, enum pixels_format format, struct rect block,
                          uint64_t revision)
{
    const struct plane *rgb[3], *alpha = NULL;
    const bool half = format == PIXELS_F16 || format == PIXELS_F16_ALPHA;
    float row[PIXELS_BLOCK_PX * 3];
    const size_t width = (size_t)rect_width(block);
    if (!image_layer_planes(image, layer, rgb)) return 0;
    if (format >= PIXELS_F16_ALPHA) alpha = alpha_of(image, layer, block);
    if (!alpha) format = half ? PIXELS_F16 : PIXELS_F32;
    write_header(out, format, (uint32_t)block.x0, (uint32_t)block.y0, (uint32_t)width,
                 (uint32_t)rect_height(block), revision);
    uint8_t *at = out + PIXELS_HEADER_BYTES;
    for (int32_t y = block.y0; y < block.y1; y++) {
        for (int c = 0; c < 3; c++) {
            const float *in = plane_at(rgb[c], block.x0, y);
            for (size_t x = 0; x < width; x++) row[x * 3 + (size_t)c] = in[x];
        }
        at = put_numbers(at, row, width * 3, half);
    }
    for (int32_t y = block.y0; alpha && y < block.y1; y++)
        at = put_numbers(at, plane_at(alpha, block.x0, y), width, half);
    return (size_t)(at - out);
}
