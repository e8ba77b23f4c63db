#pragma once
/* What the worker has in hand: frames whose plan it knows, and their tiles, from the lease to the
 * acknowledgement of the result.
 *
 *   WAITING (for the scene, and the environment map if the plan has one) -->
 *   QUEUED (with the pool) --> DONE (result kept) --> acknowledged
 *
 * A tile that was dropped while a thread traces it is stopped, and forgotten when the thread is
 * through. All calls on the loop's thread. */
#include "proto/link/message.h"
#include "proto/runtime/thread_pool.h"
#include "worker/link/link.h"
#include "worker/process/worker_log.h"
#include "worker/session/shelf.h"

struct hand;

/* A tile with its result. */
struct hand_result {
    uint64_t request_id;           /* of the lease */
    struct message_result message; /* samples: NULL; they are the buffer */
    struct shared_buffer *samples; /* borrowed */
};

struct hand_client {
    void *ctx;
    void (*result)(void *ctx, const struct hand_result *result);
    void (*faulted)(void *ctx, uint64_t request_id, const struct message_tile_fault *fault);
    void (*returned)(void *ctx, uint64_t request_id, const struct message_returned *tile);
    void (*moved)(void *ctx);      /* counts have changed: perhaps more tiles are wanted */
    struct worker_log *worker_log; /* gets a line for each end of a lease; borrowed, or NULL */
};

int hand_create(struct thread_pool *pool, struct shelf *shelf, const struct tracing *tracing,
                enum packing packing, const struct hand_client *client, struct hand **out);

/* After the pool was closed. Nulls the pointer. */
void hand_destroy(struct hand **hand);

/* A frame's plan. One that is known already is kept. ERR_MEMORY or what plan_decode refuses. */
int hand_add_frame(struct hand *hand, const struct message_frame_plan *m);

/* A lease. ERR_STATE when its frame is not known, ERR_RANGE when the rectangle does not lie in the
 * frame or the plan has no such pass, ERR_CORRUPT for counts that are not the tile's, ERR_LIMIT
 * above LIMIT_TILES_IN_HAND, ERR_MEMORY. */
int hand_add_tile(struct hand *hand, uint64_t request_id, const struct message_tile *m);

/* The result arrived: it need not be kept any longer. */
void hand_acknowledge(struct hand *hand, const struct message_ack *m);

/* Drops a frame, its tiles and results. */
void hand_cancel(struct hand *hand, uint64_t frame_id);

/* A blob became READY or FAILED. */
void hand_blob_settled(struct hand *hand, struct shelf_blob *blob);

/* The link was lost: leases not begun are the coordinator's again; tiles being traced go on. */
void hand_link_lost(struct hand *hand);
/* Another coordinator, or the same one after a restart: frame ids mean nothing any more. */
void hand_drop_all(struct hand *hand);
/* Says every kept result again. */
void hand_resend(struct hand *hand);

/* Gives back what no thread has begun; with `all`, also stops and gives back what is traced. */
void hand_return(struct hand *hand, bool all);

struct hand_counts {
    uint32_t open; /* waiting, queued or traced */
    uint32_t kept; /* results not yet acknowledged */
};
struct hand_counts hand_counts(const struct hand *hand);
bool hand_is_tracing(const struct hand *hand); /* a tile is with the pool */
uint64_t hand_rows(const struct hand *hand);   /* rows traced so far */
