#pragma once
/* The workers: their links, sessions, roster, and the local worker processes.
 *
 * The fleet knows tiles as numbers and plans as bytes. Their meaning belongs to its client, which
 * it calls on the loop's thread, and never from inside a fleet_ function. The process must ignore
 * SIGPIPE. */
#include <jansson.h>
#include <stdbool.h>
#include <uv.h>

#include "proto/link/message.h"
#include "server/fleet/worker_health.h"

struct fleet;

struct fleet_tile {
    uint64_t frame_id;
    uint32_t index, generation;
    struct plan_pass pass; /* first, count and strata all 0: the schedule's */
    struct rect rect;
    bool alone; /* its worker gets no other tile while it holds this one */
    const uint8_t *
        counts; /* the pass's strata maps as TILE has them; borrowed until it is sent; NULL: none */
    uint32_t counts_bytes;
};

/* Why a lease came back without a result. */
enum fleet_return {
    FLEET_GIVEN_BACK, /* by a worker that leaves or stops, or that it could not be sent to */
    FLEET_TAKEN_BACK, /* from one that is silent or stands still, or whose link broke */
    FLEET_SENT_AWAY,  /* from one that broke the protocol */
    FLEET_DIED,       /* a thread was at it when its worker's link broke */
};

/* What a worker says when it asks for a tile. */
struct worker_request {
    uint64_t worker;
    uint32_t capabilities;
    bool is_free; /* it holds no tile, so it may get one that must be alone */
};

struct fleet_client {
    void *ctx;
    /* Leases the next tile to this worker. False: there is none now, and fleet_wake follows later.
     */
    bool (*next_tile)(void *ctx, const struct worker_request *request, struct fleet_tile *out);
    /* Fills in what workers are told of a frame. The plan's bytes are borrowed until the frame is
     * cancelled or done. False: the frame is gone. */
    bool (*plan)(void *ctx, uint64_t frame_id, struct message_frame_plan *out);
    /* Takes a result. The client either returns a verdict, or it returns 0, takes over *bytes (to
     * be freed with free) and answers later with fleet_ack. */
    uint32_t (*result)(void *ctx, uint64_t worker, const struct message_result *result,
                       uint8_t **bytes, uint32_t size_bytes);
    void (*returned)(void *ctx, uint64_t worker, const struct fleet_tile *tile,
                     enum fleet_return why);
    /* Tells that a worker whose tiles came back with FLEET_DIED did not die of them: it lost its
     * link and is back under another id, or it was stopped from outside. */
    void (*survived)(void *ctx, uint64_t worker);
    /* Tells that a worker cannot render a tile. */
    void (*faulted)(void *ctx, uint64_t worker, const struct message_tile_fault *fault);
    /* Finds the path of a blob; false when there is none. */
    bool (*blob_path)(void *ctx, const struct digest *digest, char *out, size_t capacity);
    /* Returns about how many tiles next_tile could still give now, so that a short supply is spread
     * evenly. NULL: not known. */
    uint64_t (*tiles_left)(void *ctx);
    /* Leases a copy of a leased tile to a worker that would idle while another is late with it.
     * False: it cannot be copied. NULL: no copies; else tiles_left must be set. */
    bool (*copy_tile)(void *ctx, uint64_t worker, uint32_t capabilities,
                      const struct fleet_tile *of, struct fleet_tile *out);
};

struct fleet_options {
    const char *socket_path; /* Unix socket for local workers; owner-only */
    const char *listen;      /* "ADDR:PORT" for TCP; NULL: none */
    const char *key_path; /* what workers over TCP must have (proto/link/link_key.h); NULL: nothing,
                             and loopback only */
    const char *worker_program; /* path of shearwater-worker */
    struct log *log;            /* of refusals; local workers write as it does; NULL: as text */
    const char *cache_dir;      /* for local workers' blobs */
    const char *blob_dir;       /* local workers may map blobs from here without copying */
    unsigned local_workers, worker_threads; /* threads 0: cores / workers, at least 1 */
    uint32_t beat_ms;                       /* default 500 */
    uint32_t silence_ms;                    /* a session without a word is ended; default 10000 */
    uint32_t stall_ms; /* a tile without progress is taken back; default 10000 */
};

/* Creates the fleet and opens its listeners. On failure *fault names the option's value and the
 * reason, and what is open already is closed and freed as the loop runs on. Strings are copied. */
int fleet_create(uv_loop_t *loop, const struct fleet_options *options,
                 const struct fleet_client *client, struct fleet **out, struct fault *fault);

/* Tells local workers to drain (SIGTERM) and closes links. `closed` is called when all is released.
 * The client is not called any more. */
void fleet_close(struct fleet *fleet, void (*closed)(void *ctx), void *ctx);

/* Tells that there may be tiles again: waiting workers are served before the loop sleeps. */
void fleet_wake(struct fleet *fleet);
void fleet_ack(struct fleet *fleet, uint64_t worker, const struct message_ack *ack);
/* Drops the frame on every worker; their leases are forgotten, not returned. */
void fleet_cancel(struct fleet *fleet, uint64_t frame_id);
/* Drains a worker, or takes it back. A worker that is taken back from quarantine has no strikes any
 * more. ERR_NOT_FOUND */
int fleet_drain(struct fleet *fleet, uint64_t worker, bool drain);

/* Counts a result that does not fit its plan as a strike (worker_health.h). Returns true when this
 * puts the worker into quarantine. */
bool fleet_strike(struct fleet *fleet, uint64_t worker);
/* Takes all workers in quarantine back. */
void fleet_forgive(struct fleet *fleet);

/* Returns a worker's name, borrowed until the loop turns. NULL: it is not known (any more). */
const char *fleet_worker_name(const struct fleet *fleet, uint64_t worker);
/* Returns the version of Embree that all workers have, since the first one joined; "" before. */
const char *fleet_embree(const struct fleet *fleet);
/* Returns false once the worker's link is ending. */
bool fleet_worker_is_here(const struct fleet *fleet, uint64_t worker);

/* Lists the frames that a worker holds tiles of, with the number of each, oldest tile first.
 * Returns the number of frames, at most `most`. */
struct fleet_work {
    uint64_t frame_id;
    uint32_t tiles;
};
unsigned fleet_work(const struct fleet *fleet, uint64_t worker, struct fleet_work *out,
                    unsigned most);

/* Returns the port of the TCP listener, 0 without one. */
int fleet_port(const struct fleet *fleet);
unsigned fleet_count(const struct fleet *fleet); /* of sessions that may work */

/* What workers bring and hold, for programs that start and stop them. */
struct fleet_load {
    unsigned workers;      /* that may work */
    uint64_t threads;      /* of these */
    uint64_t tiles_leased; /* by all that are here, those included that drain or leave */
};
struct fleet_load fleet_load(const struct fleet *fleet);

/* Returns the roster as an array: id, name, state, threads, isa, build, embree, capabilities, tiles
 * in hand and done, rays, rates, bytes, rss, cpu. New reference. */
json_t *fleet_roster(const struct fleet *fleet);

struct fleet_totals {
    uint64_t bytes_received, bytes_sent, results, stale, duplicate, foreign, corrupt, returned,
        refused, respawned;
    uint64_t strikes[STRIKE_COUNT], quarantined;
    uint64_t peak_rss_bytes; /* largest worker */
};
void fleet_totals(const struct fleet *fleet, struct fleet_totals *out);
