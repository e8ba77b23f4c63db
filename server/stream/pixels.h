#pragma once
/* What a reader of the pixel feed has yet to see: a bit for each block of 64 x 64 pixels.
 *
 * A block that changes ten times before the reader is ready is sent once, with its newest pixels; a
 * reader's memory is a bit a block and one block of bytes. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/tile.h"
#include "server/image/image.h"

#define PIXELS_BLOCK_PX      64
#define PIXELS_HEADER_BYTES  32u
#define PIXELS_MESSAGE_BYTES (PIXELS_HEADER_BYTES + PIXELS_BLOCK_PX * PIXELS_BLOCK_PX * 4u * 4u)
#define PIXELS_MAGIC         0x58505753u /* "SWPX", little-endian */
#define PIXELS_VERSION       1u

/* Of a whole picture that will not change any more; below all revisions of live ones. */
#define PIXELS_STILL_REVISION 1u

/* Three numbers a pixel; behind those of all pixels, under the last two, one more: alpha. */
enum pixels_format { PIXELS_F16 = 1, PIXELS_F32 = 2, PIXELS_F16_ALPHA = 3, PIXELS_F32_ALPHA = 4 };

/* When each block of an image last changed: for readers that join, and those that come again. */
struct pixel_changes {
    int32_t width_px, height_px;
    uint64_t
        *revision; /* owned; by block, row by row; 0: never. NULL for an image without pixels */
};

struct pixel_blocks {
    int32_t width_px, height_px, columns, rows;
    uint64_t *bits; /* owned; NULL for an image without pixels */
    uint32_t count; /* of set bits */
    uint32_t next;  /* where the search goes on, so that no block starves */
};

/* No block set. ERR_MEMORY. */
int pixel_blocks_init(struct pixel_blocks *b, int32_t width_px, int32_t height_px);
void pixel_blocks_fini(struct pixel_blocks *b);

/* Sets every block that is set in the other, which is of the same image. */
void pixel_blocks_add(struct pixel_blocks *b, const struct pixel_blocks *more);
bool pixel_blocks_has(const struct pixel_blocks *b, uint32_t index);

/* Sets every block that the rectangle touches; what lies outside the image is ignored. */
void pixel_blocks_mark(struct pixel_blocks *b, struct rect changed);

/* No block changed yet. ERR_MEMORY. */
int pixel_changes_init(struct pixel_changes *c, int32_t width_px, int32_t height_px);
void pixel_changes_fini(struct pixel_changes *c);
void pixel_changes_mark(struct pixel_changes *c, struct rect changed, uint64_t revision);

/* The number of the block that begins at x, y, and how many the image has. */
uint32_t pixel_changes_block(const struct pixel_changes *c, int32_t x, int32_t y, uint32_t *count);

/* Sets every block that changed after that revision; both are of the same image. */
void pixel_blocks_join(struct pixel_blocks *b, const struct pixel_changes *from, uint64_t after);

/* Takes the next set block; false when there is none. */
bool pixel_blocks_take(struct pixel_blocks *b, struct rect *block);

/* The message that tells the image's size, PIXELS_HEADER_BYTES long. */
void pixels_write_size(uint8_t out[PIXELS_HEADER_BYTES], int32_t width_px, int32_t height_px,
                       uint64_t revision);

/* Sets the revision in a message's header. */
void pixels_set_revision(uint8_t header[PIXELS_HEADER_BYTES], uint64_t revision);

/* The message that a view begins: x and y are the size of its full picture, h its number, w 0. */
void pixels_write_view(uint8_t out[PIXELS_HEADER_BYTES], uint32_t number, int32_t width_px,
                       int32_t height_px, uint64_t revision);

/* The message of a block of a layer: its bytes, at most PIXELS_MESSAGE_BYTES; 0 when the image has
 * no such layer. Alpha goes along only where the layer has it and it is not 1 all over the block:
 * else the block has the format without. */
size_t pixels_write_block(uint8_t out[PIXELS_MESSAGE_BYTES], const struct image *image,
                          const char *layer, enum pixels_format format, struct rect block,
                          uint64_t revision);
