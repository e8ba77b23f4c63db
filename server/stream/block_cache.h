#pragma once
/* Blocks of a layer as they go out, made once for all readers of the same layer and format.
 *
 * Two hundred who watch one picture are sent the same bytes: a block is converted when the first of
 * them asks for it after a change, and kept until it changes again. With one reader alone nothing
 * is kept, and nothing beyond the budget of all caches: then each reader makes its own. Only the
 * header's revision differs: each reader sends its own. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/stream/pixels.h"

#define BLOCK_CACHE_LAYER_BYTES 32

/* A whole message, its revision 0; shared by the cache and those who are sending it. */
struct pixel_block {
    unsigned refs;
    size_t size_bytes;
    uint64_t changed; /* revision at which its pixels had changed last */
    uint8_t bytes[];
};

/* Of the memory of all caches. What readers hold that are sending it is not in it. */
struct pixel_budget {
    size_t kept_bytes;        /* by all caches now */
    size_t shared_most_bytes; /* up to which blocks of pictures in work are kept */
    size_t most_bytes;        /* up to which those of pictures that have ended are */
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

/* NULL on failed allocation or an image without that layer. One reference. */
struct pixel_block *pixel_block_create(const struct image *image, const char *layer,
                                       enum pixels_format format, struct rect rect);
void pixel_block_unref(struct pixel_block **block);

/* Finds or makes the cache in the list, and counts one more reader; NULL on failed allocation or
 * for a name that is too long. */
struct block_cache *block_cache_join(struct block_cache **list, struct pixel_budget *budget,
                                     const char *layer, enum pixels_format format);
/* The last reader's leaving frees the cache. */
void block_cache_leave(struct block_cache **list, struct block_cache **cache);

/* Forgets all blocks: the image is another one. */
void block_cache_clear(struct block_cache *cache);

/* The block at `rect` of the image, with a reference for the caller; image NULL: only what was
 * kept. NULL on failed allocation, for an image without the layer, or when it was not kept. */
struct pixel_block *block_cache_block(struct block_cache *cache, const struct image *image,
                                      const struct pixel_changes *changes, struct rect rect);

/* Makes the blocks that are set in `wanted` (taken from it), so that they outlast the image, and
 * forgets all others. ERR_LIMIT when *room bytes, of which it takes what it used, or the budget are
 * not enough for them; ERR_MEMORY. */
int block_cache_keep(struct block_cache *cache, const struct image *image,
                     const struct pixel_changes *changes, struct pixel_blocks *wanted,
                     size_t *room);
