#pragma once
/* Cuts the bytes of a pixel feed (PROTOCOL.md, "The pixel feed") into blocks. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/tile.h"

/* A block of floats, or a size if the rect is empty: the image's, or before it that of a live
 * job's view, whose images have several sizes. */
struct pixel_block {
    int32_t width_px, height_px; /* of the image or the view, when `rect` is empty */
    uint32_t view;               /* whose size that is; 0: the image's */
    struct rect rect;
    uint64_t revision;
    const float *numbers; /* three a pixel, row by row; borrowed for the call */
    const float *alpha;   /* one a pixel; NULL: opaque */
};

/* Takes a block. False: the feed is to be left. */
typedef bool (*pixel_block_taken)(void *ctx, const struct pixel_block *block);

struct pixel_parser {
    uint8_t *data; /* owned */
    size_t size_bytes, held_bytes;
    int error; /* why the last feed failed: ERR_CORRUPT, ERR_MEMORY; 0: `taken` said so */
};

void pixel_parser_fini(struct pixel_parser *p);

/* Forgets an unfinished block, as another connection begins. */
void pixel_parser_restart(struct pixel_parser *p);

/* Parses bytes. False when the feed is to be left. */
bool pixel_parser_feed(struct pixel_parser *p, const void *bytes, size_t count,
                       pixel_block_taken taken, void *ctx);
