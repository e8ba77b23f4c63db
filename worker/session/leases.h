#pragma once
/* The leases that a worker holds: frames whose plan it knows, and their tiles, from the lease to
 * the acknowledgement of the result.
 *
 *   WAITING (for the scene, and the environment map if the plan has one) -->
 *   QUEUED (with the pool) --> DONE (result kept) --> acknowledged
 *
 * A tile that is dropped while a thread traces it is stopped, and freed when the thread returns.
 * All functions are for the loop's thread. */
#include "proto/link/message.h"
#include "proto/runtime/thread_pool.h"
#include "worker/link/link.h"
#include "worker/process/worker_log.h"
#include "worker/session/blob_cache.h"

struct leases;

/* A tile with its result. */
struct lease_result {
    uint64_t request_id;           /* of the lease */
    struct message_result message; /* samples: NULL; they are the buffer */
    struct shared_buffer *samples; /* borrowed */
};

struct leases_client {
    void *ctx;
    void (*result)(void *ctx, const struct lease_result *result);
    void (*faulted)(void *ctx, uint64_t request_id, const struct message_tile_fault *fault);
    void (*returned)(void *ctx, uint64_t request_id, const struct message_returned *tile);
    void (*moved)(void *ctx);      /* counts have changed: the session may want more */
    struct worker_log *worker_log; /* gets a line for each end of a lease; borrowed, or NULL */
};

int leases_create(struct thread_pool *pool, struct blob_cache *cache, const struct tracing *tracing,
                  enum packing packing, const struct leases_client *client, struct leases **out);

/* Frees all tiles and frames. The pool must be closed. Nulls the pointer. */
void leases_destroy(struct leases **leases);

/* Adds a frame with its plan. A frame that is known already keeps its plan. ERR_MEMORY, or what
 * plan_decode returns. */
int leases_add_frame(struct leases *leases, const struct message_frame_plan *m);

/* Adds a leased tile. ERR_STATE when its frame is not known, ERR_RANGE when the rectangle does not
 * lie in the frame or the plan has no such pass, ERR_CORRUPT for counts that are not the tile's,
 * ERR_LIMIT above LIMIT_TILES_IN_HAND, ERR_MEMORY. */
int leases_add_tile(struct leases *leases, uint64_t request_id, const struct message_tile *m);

/* Frees a result that the coordinator has acknowledged. */
void leases_acknowledge(struct leases *leases, const struct message_ack *m);

/* Drops a frame, its tiles and results. */
void leases_cancel(struct leases *leases, uint64_t frame_id);

/* Queues or gives up the tiles that wait for the blob, which became READY or FAILED. */
void leases_blob_settled(struct leases *leases, struct cached_blob *blob);

/* Drops tiles that no thread has begun, since the coordinator leases them anew after a lost link.
 * Tiles that are being traced go on. */
void leases_link_lost(struct leases *leases);
/* Drops all frames: another coordinator, or one that restarted, numbers its frames anew. */
void leases_drop_all(struct leases *leases);
/* Sends every kept result again. */
void leases_resend(struct leases *leases);

/* Returns the tiles that no thread has begun. With `all`, also stops and returns those that are
 * being traced. */
void leases_return(struct leases *leases, bool all);

struct leases_counts {
    uint32_t open; /* waiting, queued or traced */
    uint32_t kept; /* results not yet acknowledged */
};
struct leases_counts leases_counts(const struct leases *leases);
bool leases_is_tracing(const struct leases *leases); /* a tile is with the pool */
uint64_t leases_rows(const struct leases *leases);   /* rows traced so far */
