#pragma once
/* The leases of one session, and a memory of leases that have ended. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/fleet/fleet.h"

struct lease {
    struct fleet_tile tile;
    uint64_t since_ms;
    uint64_t answered_before; /* results of its session when it was given */
    uint64_t begun_ms;        /* since when a thread should be tracing it; set by the table */
    bool copied;              /* another worker has a copy of it, or it cannot be copied */
};

/* A session's leases in the order in which they were given, which is the order in which a worker
 * takes them. It is empty, and for a worker with one thread, when zero-initialised. */
struct lease_table {
    struct lease *at; /* owned */
    uint32_t count, capacity;
    uint32_t threads;    /* of its worker; 0 is 1 */
    double pace_ms;      /* that a thread takes for a tile of pace_frame; 0: not known yet */
    uint64_t pace_frame; /* tiles of other frames may take another time */
};

#define LEASE_NONE UINT32_MAX

void lease_table_fini(struct lease_table *t);

/* Adds a copy of the lease. ERR_MEMORY, ERR_FULL at LIMIT_TILES_IN_HAND. */
int lease_add(struct lease_table *t, const struct lease *lease);

/* Returns the index of a lease, or LEASE_NONE. */
uint32_t lease_find(const struct lease_table *t, uint64_t frame_id, uint32_t index,
                    uint32_t generation);
/* Removes a lease; the next one begins. */
void lease_remove(struct lease_table *t, uint32_t at, uint64_t now_ms);
/* Removes a lease whose result came, and learns the worker's pace from it. */
void lease_answer(struct lease_table *t, uint32_t at, uint64_t now_ms);
/* Returns the pace, or the age of the oldest lease that has begun if that is longer, so that a
 * hanging worker counts as slow. 0: not known. */
double lease_pace_ms(const struct lease_table *t, uint64_t now_ms);
/* Returns the number of leases that threads should be tracing: the first ones. */
uint32_t lease_begun(const struct lease_table *t);
/* Returns whether there is a lease on the tile, in any generation. */
bool lease_has_tile(const struct lease_table *t, uint64_t frame_id, uint32_t index);
bool lease_has_frame(const struct lease_table *t, uint64_t frame_id);
void lease_forget_frame(struct lease_table *t, uint64_t frame_id, uint64_t now_ms);

/* Returns the first lease to take back: older than stall_ms, and either the session made no
 * progress in that time, or `overtaken` tiles given at the same time or later were answered since
 * (one thread of a busy worker hangs). LEASE_NONE: there is none. */
uint32_t lease_stalled(const struct lease_table *t, uint64_t now_ms, uint64_t progress_ms,
                       uint64_t answered, uint64_t overtaken, uint32_t stall_ms);

/* The latest leases that ended otherwise than with their frame. The client judges a result for one
 * of these; a result for a tile that was never leased is foreign. */
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
