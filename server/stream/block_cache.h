#pragma once
/* Encoded blocks of a layer, made once for all readers of the same layer and format.
 *
 * All viewers of one picture are sent the same bytes. A block is encoded when the first reader asks
 * for it after a change, and kept until it changes again. Nothing is kept for a single reader, nor
 * beyond the budget of all caches: each reader then encodes its own. Only the revision in the
 * header differs from reader to reader. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/stream/pixels.h"

#define BLOCK_CACHE_LAYER_BYTES 32

/* A whole message with revision 0, shared by the cache and the readers that are sending it. */
struct pixel_block {
    unsigned refs;
    size_t size_bytes;
    uint64_t changed; /* revision of the last change of its pixels */
    uint8_t bytes[];
};

/* The memory of all caches, without blocks that only readers hold. */
struct pixel_budget {
    size_t kept_bytes;       /* by all caches now */
    size_t shared_max_bytes; /* limit for blocks of pictures in work */
    size_t most_bytes;       /* limit for blocks of pictures that have ended */
};

struct block_cache {
    struct block_cache *next;
    struct pixel_budget *budget; /* outlives it */
    char layer[BLOCK_CACHE_LAYER_BYTES];
    enum pixels_format format;
    unsigned readers;
    uint64_t made;              /* blocks, over its life */
    uint32_t count;             /* of blocks; 0: none yet of the image */
    struct pixel_block **block; /* owned; NULL each: not made */
};

/* Encodes a block. NULL on failed allocation, or when the image has no such layer. One reference.
 */
struct pixel_block *pixel_block_create(const struct image *image, const char *layer,
                                       enum pixels_format format, struct rect rect);
void pixel_block_unref(struct pixel_block **block);

/* Finds or creates the cache in the list, and counts one more reader. NULL on failed allocation, or
 * for a name that is too long. */
struct block_cache *block_cache_join(struct block_cache **list, struct pixel_budget *budget,
                                     const char *layer, enum pixels_format format);
/* Counts one reader less; the last one frees the cache. */
void block_cache_leave(struct block_cache **list, struct block_cache **cache);

/* Forgets all blocks, since the image is another one. */
void block_cache_clear(struct block_cache *cache);

/* Returns the block at `rect` of the image, with a reference for the caller. image NULL: only if it
 * is kept. NULL on failed allocation, for an image without the layer, or when it was not kept. */
struct pixel_block *block_cache_block(struct block_cache *cache, const struct image *image,
                                      const struct pixel_changes *changes, struct rect rect);

/* Encodes the blocks that are set in `wanted` (taken from it), so that they outlast the image, and
 * forgets all others. ERR_LIMIT when they need more than the budget or than *room bytes, which
 * becomes what is left; ERR_MEMORY. */
int block_cache_keep(struct block_cache *cache, const struct image *image,
                     const struct pixel_changes *changes, struct pixel_blocks *wanted,
                     size_t *room);
