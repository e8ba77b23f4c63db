#pragma once
/* One worker link as the coordinator sees it: its state, its leases, its unanswered results.
 *
 * GREETING --HELLO--> WORKING <--> DRAINING --BYE--> LEAVING --> CLOSING
 *
 * A HELLO that is refused leads from GREETING to LEAVING. Any state goes to CLOSING when the link
 * breaks, a message is out of state or cannot be decoded, or the session is silent for too long.
 * Each message has one small step function per state, in a table. A message that the table does not
 * have ends the session.
 *
 * A session decides nothing about tiles or jobs: it asks its host. All calls are on the loop's
 * thread. */
#include <stdbool.h>
#include <uv.h>

#include "proto/link/channel.h"
#include "proto/link/message.h"
#include "proto/link/wire_frame.h"
#include "server/fleet/blobs.h"
#include "server/fleet/fleet.h"
#include "server/fleet/lease.h"
#include "server/fleet/outbox.h"

/* Bounds of what one session may have in flight. */
#define SESSION_HELLO_MS          5000u        /* ms from connecting to HELLO */
#define SESSION_LEAVE_MS          1000u        /* ms that a refusal may take to be read */
#define SESSION_UNACKED_BYTES     (32u << 20)  /* bytes of results that the client still holds */
#define SESSION_BACKLOG_BYTES     (4u << 20)   /* bytes that wait to be written */
#define SESSION_ALL_UNACKED_BYTES (256u << 20) /* the same over all sessions */
#define SESSION_FRAMES            64u          /* frames without leases that a worker remembers */

enum session_state {
    SESSION_GREETING, /* connected, HELLO is awaited */
    SESSION_WORKING,
    SESSION_DRAINING, /* gets no more tiles */
    SESSION_LEAVING,  /* refused or said BYE: the last bytes go out, nothing is listened to */
    SESSION_CLOSING,
    SESSION_STATE_COUNT
};

struct session;

struct session_host {
    void *ctx;
    /* Decides whether this worker may join: true and *welcome, or false and *refused. */
    bool (*greet)(void *ctx, struct session *s, struct message_welcome *welcome,
                  struct message_refused *refused);
    /* Tells that it was refused: its name is "" where the HELLO cannot be read. */
    void (*refused)(void *ctx, const struct session *s, const struct message_refused *refused);
    /* Takes a result that was decoded but not judged; request_id is for the answer. */
    int (*result)(void *ctx, struct session *s, uint64_t request_id,
                  const struct message_result *result);
    void (*returned)(void *ctx, struct session *s, const struct fleet_tile *tile,
                     enum fleet_return why);
    /* Tells that its link broke while it held tiles. Returns whether it may have died of a tile. */
    bool (*gone)(void *ctx, const struct session *s);
    /* Tells that it is being dropped, since it was silent for too long. */
    void (*silent)(void *ctx, const struct session *s);
    /* Tells of a strike. The session may be put into quarantine from inside. */
    void (*struck)(void *ctx, struct session *s, enum strike kind);
    void (*faulted)(void *ctx, struct session *s, const struct message_tile_fault *fault);
    bool (*blob_path)(void *ctx, const struct digest *digest, char *out, size_t capacity);
    size_t *unacked_bytes;   /* unacknowledged over all sessions */
    void (*wake)(void *ctx); /* session_turn is wanted before the loop sleeps */
    void (*closed)(void *ctx, struct session *s); /* the last call; the host frees it */
};

/* A result that the client took over and has not judged. */
struct session_unacked {
    struct lease_key tile;
    uint64_t request_id;
    uint32_t size_bytes;
};

struct session {
    union {
        uv_handle_t any;
        uv_stream_t stream;
        uv_tcp_t tcp;
        uv_pipe_t pipe;
    } handle;
    const struct session_host *host; /* borrowed */
    struct fleet_totals *totals;     /* borrowed */
    uint64_t id;
    enum session_state state;
    bool local;              /* over the Unix socket */
    struct channel *channel; /* owned; NULL: in the clear */
    bool reading;            /* libuv reads this link */
    bool stalled;            /* its tiles were taken back; it gets none until it shows progress */
    uint64_t quarantined_until_ms; /* the quarantine in which it drains; 0: none */
    struct wire_frame_inbox inbox;
    struct outbox outbox;
    struct lease_table leases;
    struct blob_source blob;
    struct message_hello hello;
    struct message_beat beat; /* the last one */
    uint32_t want;            /* tiles it asked for and did not get */
    uint64_t connected_ms, heard_ms, progress_ms, left_ms;
    uint64_t next_request;
    uint64_t *frames; /* owned: frames whose plan was sent, oldest first */
    uint32_t frame_count;
    struct session_unacked *unacked; /* owned */
    uint32_t unacked_count, unacked_capacity;
    size_t unacked_bytes;
    /* For the roster. */
    uint64_t answered, rays, received_bytes, sent_bytes;
    double tiles_per_s, rays_per_s;
    uint64_t rate_ms, rate_tiles, rate_rays; /* where the window of the rates began */
};

const char *session_state_name(enum session_state state);

/* Creates a session on a handle that the caller accepts into handle.stream afterwards. tcp: the
 * kind of handle. key: the link key that the worker must have; NULL: none. ERR_MEMORY, ERR_IO,
 * ERR_UNSUPPORTED. */
int session_create(uv_loop_t *loop, bool tcp, const struct link_key *key, uint64_t id,
                   const struct session_host *host, struct fleet_totals *totals,
                   struct session **out);

/* Begins to read. */
void session_start(struct session *s);

/* Frees what a session holds; only from host->closed. */
void session_destroy(struct session **s);

/* The reason why a session ended without a BYE. */
enum session_end { SESSION_BROKE, SESSION_BREACHED, SESSION_SILENT };

/* Ends the session; its leases come back through host->returned. Never from inside a fleet_
 * function. */
void session_end(struct session *s, enum session_end why);

/* Ends the session without an event, as the fleet closes. */
void session_drop(struct session *s);

bool session_may_work(const struct session *s); /* may be given tiles */
/* Returns whether it wants more and holds no tile that must be alone. */
bool session_takes_more(const struct session *s);

/* Ends a turn of the loop: reads on where a limit had stopped it, writes what was gathered, ends a
 * session whose link has failed. */
void session_turn(struct session *s);

/* Checks the clocks: HELLO, silence, leaving, and stalled leases (taken back). */
void session_tick(struct session *s, uint64_t now_ms, uint32_t silence_ms, uint32_t stall_ms);

/* Give the worker a lease, and before it the frame's plan, when this link has not seen it. Without
 * memory the lease is not given. */
bool session_knows_frame(const struct session *s, uint64_t frame_id);
int session_send_plan(struct session *s, const struct message_frame_plan *plan);
int session_send_tile(struct session *s, const struct fleet_tile *tile, uint64_t now_ms);

/* Sends the verdict on a result, also on one that is not (or no longer) unacknowledged, whose
 * RESULT came with request_id (0: not known). */
void session_ack(struct session *s, const struct message_ack *ack, uint64_t request_id);
int session_add_unacked(struct session *s, uint64_t request_id, const struct message_result *r);
void session_cancel(struct session *s, uint64_t frame_id);
void session_drain(struct session *s, bool drain);
/* Drains the worker until then, unless it drains already. 0: ends the quarantine, and with it the
 * draining. */
void session_quarantine(struct session *s, uint64_t until_ms);

/* ---- between the session's own files ---- */

bool session_is_listening(const struct session *s);
/* Follows the table of legal transitions; aborts on a step outside it. */
void session_enter(struct session *s, enum session_state next);
/* Gives the leases back, lets the last bytes go out, then closes. */
void session_leave(struct session *s);
/* Acts on one message. A negative code: the session must end. */
int session_take(struct session *s, const struct wire_frame_view *f);
/* Refuses a greeting that could not be read, in words for its error code, and leaves. */
void session_refuse_greeting(struct session *s, uint64_t request_id, int error);
