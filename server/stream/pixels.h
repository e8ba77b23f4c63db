#pragma once
/* The blocks of 64 x 64 pixels that a reader of the pixel feed has yet to see, one bit each.
 *
 * A block that changes ten times before the reader is ready is sent once, with its newest pixels. A
 * reader needs memory for one bit a block and for the bytes of one block. */
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

/* Revision of a whole picture that will not change any more; below all revisions of active jobs. */
#define PIXELS_STILL_REVISION 1u

/* Three numbers a pixel. The last two formats append one number a pixel after them: alpha. */
enum pixels_format { PIXELS_F16 = 1, PIXELS_F32 = 2, PIXELS_F16_ALPHA = 3, PIXELS_F32_ALPHA = 4 };

/* The revision at which each block of an image last changed, for readers that join or come again.
 */
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

/* Starts with no block set. ERR_MEMORY. */
int pixel_blocks_init(struct pixel_blocks *b, int32_t width_px, int32_t height_px);
void pixel_blocks_fini(struct pixel_blocks *b);

/* Sets every block that is set in the other set, which is of the same image. */
void pixel_blocks_add(struct pixel_blocks *b, const struct pixel_blocks *more);
bool pixel_blocks_has(const struct pixel_blocks *b, uint32_t index);

/* Sets every block that the rectangle touches; what lies outside the image is ignored. */
void pixel_blocks_mark(struct pixel_blocks *b, struct rect changed);

/* Starts with no block changed. ERR_MEMORY. */
int pixel_changes_init(struct pixel_changes *c, int32_t width_px, int32_t height_px);
void pixel_changes_fini(struct pixel_changes *c);
void pixel_changes_mark(struct pixel_changes *c, struct rect changed, uint64_t revision);

/* Returns the index of the block that begins at x, y; *count is how many the image has. */
uint32_t pixel_changes_block(const struct pixel_changes *c, int32_t x, int32_t y, uint32_t *count);

/* Sets every block that changed after that revision; both are of the same image. */
void pixel_blocks_join(struct pixel_blocks *b, const struct pixel_changes *from, uint64_t after);

/* Takes the next set block; false when there is none. */
bool pixel_blocks_take(struct pixel_blocks *b, struct rect *block);

/* Writes the message with the image's size, PIXELS_HEADER_BYTES long. */
void pixels_write_size(uint8_t out[PIXELS_HEADER_BYTES], int32_t width_px, int32_t height_px,
                       uint64_t revision);

/* Sets the revision in a message's header. */
void pixels_set_revision(uint8_t header[PIXELS_HEADER_BYTES], uint64_t revision);

/* Writes the message that begins a view: x and y are the size of its full picture, h its number, w
 * 0. */
void pixels_write_view(uint8_t out[PIXELS_HEADER_BYTES], uint32_t number, int32_t width_px,
                       int32_t height_px, uint64_t revision);

/* Writes the message of a block of a layer, and returns its bytes, at most PIXELS_MESSAGE_BYTES; 0
 * when the image has no such layer. Alpha is sent only where the layer has it and it is not 1 all
 * over the block; else the block has the format without. */
size_t pixels_write_block(uint8_t out[PIXELS_MESSAGE_BYTES], const struct image *image,
                          const char *layer, enum pixels_format format, struct rect block,
                          uint64_t revision);
