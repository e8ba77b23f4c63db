#include "server/stream/events.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"

#define FIRST_CAPACITY 8u

void event_text_unref(struct event_text **text)
{
    if (*text && --(*text)->refs == 0) free(*text);
    *text = NULL;
}

struct event_text *event_text_create(uint32_t epoch, uint64_t id, const char *name,
                                     const json_t *data)
{
    char head[128];
    /* Compact JSON holds no raw line break: jansson escapes every control character. */
    char *json = json_text(data, JSON_COMPACT | JSON_ENCODE_ANY);
    if (!json) return NULL;
    int head_bytes = snprintf(
        head, sizeof head, "id: %08" PRIx32 "-%" PRIu64 "\nevent: %.40s\ndata: ", epoch, id, name);
    size_t json_bytes = strlen(json), size_bytes = (size_t)head_bytes + json_bytes + 2;
    struct event_text *text = malloc(sizeof *text + size_bytes);
    if (text) {
        text->refs = 1;
        text->size_bytes = size_bytes;
        /* NOLINTBEGIN(bugprone-not-null-terminated-result): bytes with a size, no string */
        memcpy(text->bytes, head, (size_t)head_bytes);
        memcpy(text->bytes + head_bytes, json, json_bytes);
        memcpy(text->bytes + (size_t)head_bytes + json_bytes, "\n\n", 2);
        /* NOLINTEND(bugprone-not-null-terminated-result) */
    }
    free(json);
    return text;
}

void event_ring_init(struct event_ring *ring, uint32_t epoch)
{
    *ring = (struct event_ring){.epoch = epoch};
}

void event_ring_fini(struct event_ring *ring)
{
    for (uint32_t i = 0; i < ring->capacity; i++) event_text_unref(&ring->slot[i].text);
    free(ring->slot);
    ring->slot = NULL;
    ring->capacity = ring->count = 0;
}

static struct event_slot *slot_of(const struct event_ring *ring, uint64_t id)
{
    return &ring->slot[id & (ring->capacity - 1)];
}

static uint64_t oldest_id(const struct event_ring *ring)
{
    return ring->last_id - ring->count + 1;
}

static int grow(struct event_ring *ring)
{
    uint32_t capacity = ring->capacity ? ring->capacity * 2 : FIRST_CAPACITY;
    struct event_slot *slot = calloc(capacity, sizeof *slot);
    if (!slot) return ERR_MEMORY;
    for (uint64_t id = oldest_id(ring); id <= ring->last_id && ring->count; id++)
        slot[id & (capacity - 1)] = *slot_of(ring, id);
    free(ring->slot);
    ring->slot = slot;
    ring->capacity = capacity;
    return 0;
}

static void drop_oldest(struct event_ring *ring)
{
    uint64_t id = oldest_id(ring);
    struct event_slot *slot = slot_of(ring, id);
    if (slot->kind == EVENT_KEPT) ring->lost_id = id;
    event_text_unref(&slot->text);
    ring->count--;
}

static enum event_kind kind_of(const char *name)
{
    if (strcmp(name, "progress") == 0) return EVENT_PROGRESS;
    return strcmp(name, "tile") == 0 ? EVENT_TILE : EVENT_KEPT;
}

int event_ring_push(struct event_ring *ring, const char *name, const json_t *data)
{
    uint64_t id = ring->last_id + 1;
    struct event_text *text = event_text_create(ring->epoch, id, name, data);
    if (text && ring->count == ring->capacity && ring->capacity < LIMIT_EVENT_RING)
        (void)grow(ring); /* without room to grow the ring stays short */
    if (!text || ring->capacity == 0) {
        event_text_unref(&text);
        while (ring->count) drop_oldest(ring);
        ring->last_id = ring->lost_id = id;
        return ERR_MEMORY;
    }
    if (ring->count == ring->capacity) drop_oldest(ring);
    enum event_kind kind = kind_of(name);
    *slot_of(ring, id) = (struct event_slot){kind, text};
    ring->last_id = ring->newest[kind] = id;
    ring->count++;
    return 0;
}

bool event_ring_has_after(const struct event_ring *ring, uint64_t cursor)
{
    return cursor <= ring->last_id && ring->lost_id <= cursor;
}

/* The id of the next event worth sending; 0 when there is none. */
static uint64_t next_id(const struct event_ring *ring, uint64_t cursor)
{
    if (ring->count == 0 || cursor >= ring->last_id) return 0;
    uint64_t id = cursor + 1 > oldest_id(ring) ? cursor + 1 : oldest_id(ring);
    for (; id < ring->last_id; id++) {
        enum event_kind kind = slot_of(ring, id)->kind;
        if (kind == EVENT_KEPT || ring->newest[kind] == id) break;
    }
    return id;
}

bool event_ring_pending(const struct event_ring *ring, uint64_t cursor)
{
    return next_id(ring, cursor) != 0;
}

struct event_text *event_ring_next(const struct event_ring *ring, uint64_t *cursor)
{
    uint64_t id = next_id(ring, *cursor);
    if (id == 0) return NULL;
    struct event_text *text = slot_of(ring, id)->text;
    text->refs++;
    *cursor = id;
    return text;
}

uint64_t event_id_read(uint32_t epoch, const char *text)
{
    char prefix[16];
    int prefix_bytes = snprintf(prefix, sizeof prefix, "%08" PRIx32 "-", epoch);
    if (strncmp(text, prefix, (size_t)prefix_bytes) != 0) return 0;
    text += prefix_bytes;
    size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > 19 || text[digits]) return 0;
    return strtoull(text, NULL, 10);
}
