#pragma once
/* Internals of the leases, for their own files alone: leases_add.c takes frames and tiles in,
 * leases.c has what becomes of them. */
#include "worker/session/frame_blobs.h"
#include "worker/session/leases.h"

struct leased_frame {
    struct leased_frame *next;
    uint64_t id;
    char job[LIMIT_JOB_ID_BYTES]; /* whose it is */
    struct trace_context trace;   /* of the request that submitted that; zero: not known */
    struct frame_blobs blobs;     /* held while tiles are open */
    uint32_t tiles;               /* all that point here */
    uint32_t open;                /* of them, not DONE and not dropped */
    bool gone;                    /* cancelled: freed with its last tile */
    struct plan plan;
};

enum tile_state { TILE_WAITING, TILE_QUEUED, TILE_DONE, TILE_DROPPED };

struct leased_tile {
    struct pool_task task;
    struct leased_tile *next, *previous;
    struct leases *leases;
    struct leased_frame *frame;
    enum tile_state state;
    uint64_t request_id;
    struct message_tile lease;
    uint8_t *strata_maps; /* owned; of a pass that has them, map after map */
    _Atomic bool stop;
    struct tracing_job job; /* once it is queued */
    struct bytes_writer packed;
    struct counters counters;
    int error;
    struct shared_buffer *samples; /* DONE */
};

struct leases {
    struct thread_pool *pool;
    struct blob_cache *cache;
    const struct tracing *tracing;
    enum packing packing;
    struct leases_client client;
    struct leased_frame *frames;
    struct leased_tile *first, *last; /* in the order of their leases */
    struct leases_counts counts;
    _Atomic uint64_t rows;
};

/* Returns NULL where the frame is not known. */
struct leased_frame *leases_find_frame(const struct leases *leases, uint64_t id);

/* Appends a tile to the list of all. */
void leases_append(struct leases *leases, struct leased_tile *t);

/* Queues a waiting tile when its blobs are ready, and gives it up when one of them has failed. */
void leases_go_on(struct leases *leases, struct leased_tile *t);
