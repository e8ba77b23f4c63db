#include "server/fleet/lease.h"

#include <stdlib.h>
#include <string.h>

void lease_table_fini(struct lease_table *t)
{
    free(t->at);
    *t = (struct lease_table){0};
}

int lease_add(struct lease_table *t, const struct lease *lease)
{
    if (t->count >= LIMIT_TILES_IN_HAND) return ERR_FULL;
    if (t->count == t->capacity) {
        uint32_t capacity = t->capacity ? 2 * t->capacity : 8;
        struct lease *at = realloc(t->at, capacity * sizeof *at);
        if (!at) return ERR_MEMORY;
        t->at = at;
        t->capacity = capacity;
    }
    t->at[t->count++] = *lease;
    return 0;
}

uint32_t lease_find(const struct lease_table *t, uint64_t frame_id, uint32_t index,
                    uint32_t generation)
{
    for (uint32_t i = 0; i < t->count; i++) {
        const struct fleet_tile *tile = &t->at[i].tile;
        if (tile->index == index && tile->frame_id == frame_id && tile->generation == generation)
            return i;
    }
    return LEASE_NONE;
}

void lease_remove(struct lease_table *t, uint32_t at)
{
    t->count--;
    memmove(&t->at[at], &t->at[at + 1], (t->count - at) * sizeof t->at[0]);
}

bool lease_has_tile(const struct lease_table *t, uint64_t frame_id, uint32_t index)
{
    for (uint32_t i = 0; i < t->count; i++)
        if (t->at[i].tile.index == index && t->at[i].tile.frame_id == frame_id) return true;
    return false;
}

bool lease_has_frame(const struct lease_table *t, uint64_t frame_id)
{
    for (uint32_t i = 0; i < t->count; i++)
        if (t->at[i].tile.frame_id == frame_id) return true;
    return false;
}

void lease_forget_frame(struct lease_table *t, uint64_t frame_id)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < t->count; i++)
        if (t->at[i].tile.frame_id != frame_id) t->at[kept++] = t->at[i];
    t->count = kept;
}

static bool is_stalled(const struct lease *lease, uint64_t now_ms, uint64_t progress_ms,
                       uint64_t answered, uint64_t overtaken, uint32_t stall_ms)
{
    if (now_ms - lease->since_ms < stall_ms) return false;
    return now_ms - progress_ms >= stall_ms || answered - lease->answered_before >= overtaken;
}

uint32_t lease_stalled(const struct lease_table *t, uint64_t now_ms, uint64_t progress_ms,
                       uint64_t answered, uint64_t overtaken, uint32_t stall_ms)
{
    for (uint32_t i = 0; i < t->count; i++)
        if (is_stalled(&t->at[i], now_ms, progress_ms, answered, overtaken, stall_ms)) return i;
    return LEASE_NONE;
}

static const struct lease_key no_key = {.index = UINT32_MAX, .generation = UINT32_MAX};

void lease_past_init(struct lease_past *past)
{
    for (uint32_t i = 0; i < LEASE_PAST_COUNT; i++) past->ring[i] = no_key;
    past->next = 0;
}

void lease_past_add(struct lease_past *past, uint64_t frame_id, uint32_t index, uint32_t generation)
{
    past->ring[past->next] =
        (struct lease_key){.frame_id = frame_id, .index = index, .generation = generation};
    past->next = (past->next + 1) % LEASE_PAST_COUNT;
}

bool lease_past_has(const struct lease_past *past, uint64_t frame_id, uint32_t index,
                    uint32_t generation)
{
    if (index == UINT32_MAX) return false; /* marks an empty place */
    for (uint32_t i = 0; i < LEASE_PAST_COUNT; i++) {
        const struct lease_key *key = &past->ring[i];
        if (key->index == index && key->frame_id == frame_id && key->generation == generation)
            return true;
    }
    return false;
}

void lease_past_forget_frame(struct lease_past *past, uint64_t frame_id)
{
    for (uint32_t i = 0; i < LEASE_PAST_COUNT; i++)
        if (past->ring[i].frame_id == frame_id) past->ring[i] = no_key;
}
