#include "server/stream/block_cache.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"

struct pixel_block *pixel_block_create(const struct image *image, const char *layer,
                                       enum pixels_format format, struct rect rect)
{
    uint8_t message[PIXELS_MESSAGE_BYTES];
    const size_t size_bytes = pixels_write_block(message, image, layer, format, rect, 0);
    struct pixel_block *block = size_bytes > 0 ? malloc(sizeof *block + size_bytes) : NULL;
    if (!block) return NULL;
    *block = (struct pixel_block){.refs = 1, .size_bytes = size_bytes};
    memcpy(block->bytes, message, size_bytes);
    return block;
}

void pixel_block_unref(struct pixel_block **block)
{
    if (*block && --(*block)->refs == 0) free(*block);
    *block = NULL;
}

/* Keeps the block in the cache's place, with a reference of its own, if all blocks stay within
 * `most_bytes`. */
static bool keep(struct block_cache *cache, struct pixel_block **place, struct pixel_block *block,
                 size_t most_bytes)
{
    struct pixel_budget *budget = cache->budget;
    if (budget->kept_bytes > most_bytes || block->size_bytes > most_bytes - budget->kept_bytes)
        return false;
    budget->kept_bytes += block->size_bytes;
    block->refs++;
    *place = block;
    return true;
}

static void let_go(struct block_cache *cache, struct pixel_block **place)
{
    if (*place) cache->budget->kept_bytes -= (*place)->size_bytes;
    pixel_block_unref(place);
}

struct block_cache *block_cache_join(struct block_cache **list, struct pixel_budget *budget,
                                     const char *layer, enum pixels_format format)
{
    struct block_cache *cache = *list;
    if (strlen(layer) >= BLOCK_CACHE_LAYER_BYTES) return NULL;
    while (cache && (cache->format != format || strcmp(cache->layer, layer) != 0))
        cache = cache->next;
    if (!cache) {
        cache = calloc(1, sizeof *cache);
        if (!cache) return NULL;
        memcpy(cache->layer, layer, strlen(layer) + 1);
        cache->format = format;
        cache->budget = budget;
        cache->next = *list;
        *list = cache;
    }
    cache->readers++;
    return cache;
}

void block_cache_clear(struct block_cache *cache)
{
    for (uint32_t i = 0; i < cache->count; i++) let_go(cache, &cache->block[i]);
    free(cache->block);
    cache->block = NULL;
    cache->count = 0;
}

void block_cache_leave(struct block_cache **list, struct block_cache **cache)
{
    struct block_cache *s = *cache;
    *cache = NULL;
    if (!s || --s->readers > 0) return;
    while (*list != s) list = &(*list)->next;
    *list = s->next;
    block_cache_clear(s);
    free(s);
}

/* Returns where the block is kept; NULL without memory for places. */
static struct pixel_block **place_of(struct block_cache *cache, uint32_t count, uint32_t index)
{
    if (cache->count != count) {
        block_cache_clear(cache);
        cache->block = calloc(count, sizeof(struct pixel_block *));
        if (!cache->block) return NULL;
        cache->count = count;
    }
    return &cache->block[index];
}

static struct pixel_block *with_ref(struct pixel_block *block)
{
    block->refs++;
    return block;
}

struct pixel_block *block_cache_block(struct block_cache *cache, const struct image *image,
                                      const struct pixel_changes *changes, struct rect rect)
{
    uint32_t count, index = pixel_changes_block(changes, rect.x0, rect.y0, &count);
    struct pixel_block **place = place_of(cache, count, index);
    const uint64_t changed = changes->revision[index];
    if (place && *place && (*place)->changed == changed) return with_ref(*place);
    if (!image) return NULL;
    struct pixel_block *block = pixel_block_create(image, cache->layer, cache->format, rect);
    if (!block) return NULL;
    block->changed = changed;
    cache->made++;
    if (!place) return block;
    let_go(cache, place);
    if (cache->readers > 1) (void)keep(cache, place, block, cache->budget->shared_max_bytes);
    return block;
}

static int keep_block(struct block_cache *cache, const struct image *image,
                      const struct pixel_changes *changes, struct rect rect, size_t *room)
{
    uint32_t count, index = pixel_changes_block(changes, rect.x0, rect.y0, &count);
    struct pixel_block *block = block_cache_block(cache, image, changes, rect);
    struct pixel_block **place = place_of(cache, count, index);
    int error = !block || !place ? ERR_MEMORY : block->size_bytes > *room ? ERR_LIMIT : 0;
    if (!error) *room -= block->size_bytes;
    if (!error && !*place && !keep(cache, place, block, cache->budget->most_bytes))
        error = ERR_LIMIT;
    pixel_block_unref(&block);
    return error;
}

int block_cache_keep(struct block_cache *cache, const struct image *image,
                     const struct pixel_changes *changes, struct pixel_blocks *wanted, size_t *room)
{
    struct rect rect;
    int error = 0;
    for (uint32_t i = 0; i < cache->count; i++)
        if (!pixel_blocks_has(wanted, i)) let_go(cache, &cache->block[i]);
    while (!error && pixel_blocks_take(wanted, &rect))
        error = keep_block(cache, image, changes, rect, room);
    return error;
}
