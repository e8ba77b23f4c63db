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
    t->at[t->count] = *lease;
    t->at[t->count].copied = false;
    t->at[t->count++].begun_ms = lease->since_ms;
    return 0;
}

uint32_t lease_begun(const struct lease_table *t)
{
    const uint32_t threads = t->threads > 0 ? t->threads : 1;
    return t->count < threads ? t->count : threads;
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

void lease_remove(struct lease_table *t, uint32_t at, uint64_t now_ms)
{
    const uint32_t begun = lease_begun(t);
    t->count--;
    memmove(&t->at[at], &t->at[at + 1], (t->count - at) * sizeof t->at[0]);
    if (at < begun && t->count >= begun) t->at[begun - 1].begun_ms = now_ms;
}

/* How much of the pace the last tile is. */
#define PACE_PART 0.25

void lease_answer(struct lease_table *t, uint32_t at, uint64_t now_ms)
{
    if (at < lease_begun(t)) {
        const double took_ms = (double)(now_ms - t->at[at].begun_ms);
        if (t->at[at].tile.frame_id != t->pace_frame) t->pace_ms = 0;
        t->pace_frame = t->at[at].tile.frame_id;
        t->pace_ms = t->pace_ms > 0 ? t->pace_ms + PACE_PART * (took_ms - t->pace_ms) : took_ms;
        if (t->pace_ms < 1) t->pace_ms = 1; /* the clock's step */
    }
    lease_remove(t, at, now_ms);
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

void lease_forget_frame(struct lease_table *t, uint64_t frame_id, uint64_t now_ms)
{
    for (uint32_t i = t->count; i-- > 0;)
        if (t->at[i].tile.frame_id == frame_id) lease_remove(t, i, now_ms);
    if (t->pace_frame == frame_id) t->pace_ms = 0;
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

double lease_pace_ms(const struct lease_table *t, uint64_t now_ms)
{
    double pace_ms = t->pace_ms;
    for (uint32_t i = 0; i < lease_begun(t) && pace_ms > 0; i++) {
        const double since_ms = (double)(now_ms - t->at[i].begun_ms);
        if (since_ms > pace_ms) pace_ms = since_ms;
    }
    return pace_ms;
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
