#pragma once
/* Who holds which tile: the leases of one session, and a memory of leases that have ended. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/fleet/fleet.h"

struct lease {
    struct fleet_tile tile;
    uint64_t since_ms;
    uint64_t answered_before; /* results of its session when it was given */
};

/* In the order in which they were given. Zero-initialised is empty. */
struct lease_table {
    struct lease *at; /* owned */
    uint32_t count, capacity;
};

#define LEASE_NONE UINT32_MAX

void lease_table_fini(struct lease_table *t);

/* ERR_MEMORY, ERR_FULL at LIMIT_TILES_IN_HAND. */
int lease_add(struct lease_table *t, const struct lease *lease);

/* Index of a lease, or LEASE_NONE. */
uint32_t lease_find(const struct lease_table *t, uint64_t frame_id, uint32_t index,
                    uint32_t generation);
void lease_remove(struct lease_table *t, uint32_t at);
/* A lease on the tile in any generation. */
bool lease_has_tile(const struct lease_table *t, uint64_t frame_id, uint32_t index);
bool lease_has_frame(const struct lease_table *t, uint64_t frame_id);
void lease_forget_frame(struct lease_table *t, uint64_t frame_id);

/* The first lease that is to be taken back: older than stall_ms, and either the session made no
 * progress in that time, or `overtaken` tiles given at the same time or later were answered since
 * (one thread of a busy worker hangs). LEASE_NONE: all is well. */
uint32_t lease_stalled(const struct lease_table *t, uint64_t now_ms, uint64_t progress_ms,
                       uint64_t answered, uint64_t overtaken, uint32_t stall_ms);

/* The latest leases that ended in any way but by their frame's end. A result for one of these is
 * the client's to judge; a result for a tile that was never leased is foreign. */
#define LEASE_PAST_COUNT 4096
struct lease_key {
    uint64_t frame_id;
    uint32_t index, generation;
};
struct lease_past {
    struct lease_key ring[LEASE_PAST_COUNT]; /* generation UINT32_MAX, index UINT32_MAX: empty */
    uint32_t next;
};

void lease_past_init(struct lease_past *past);
void lease_past_add(struct lease_past *past, uint64_t frame_id, uint32_t index,
                    uint32_t generation);
bool lease_past_has(const struct lease_past *past, uint64_t frame_id, uint32_t index,
                    uint32_t generation);
void lease_past_forget_frame(struct lease_past *past, uint64_t frame_id);
