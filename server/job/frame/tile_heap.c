#include "server/job/frame/tile_heap.h"

void tile_heap_push(struct tile_heap *heap, struct tile_key key)
{
    uint32_t at = heap->count++;
    while (at > 0 && tile_key_before(&key, &heap->keys[(at - 1) / 2])) {
        heap->keys[at] = heap->keys[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    heap->keys[at] = key;
}

/* Puts `key` at `at` or below. */
static void sink(struct tile_heap *heap, uint32_t at, struct tile_key key)
{
    for (;;) {
        uint32_t child = 2 * at + 1;
        if (child >= heap->count) break;
        if (child + 1 < heap->count && tile_key_before(&heap->keys[child + 1], &heap->keys[child]))
            child++;
        if (!tile_key_before(&heap->keys[child], &key)) break;
        heap->keys[at] = heap->keys[child];
        at = child;
    }
    heap->keys[at] = key;
}

uint32_t tile_heap_pop(struct tile_heap *heap)
{
    const uint32_t tile = heap->keys[0].tile;
    const struct tile_key last = heap->keys[--heap->count];
    if (heap->count > 0) sink(heap, 0, last);
    return tile;
}

void tile_heap_restore(struct tile_heap *heap)
{
    for (uint32_t at = heap->count / 2; at-- > 0;) sink(heap, at, heap->keys[at]);
}
