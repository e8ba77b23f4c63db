#pragma once
/* The worker's side of the protocol: which message is legal in which state, and how a worker joins
 * and leaves.
 *
 *   OFFLINE --connected--> GREETING --WELCOME--> WORKING <--TILE/DRAIN--> DRAINING
 *   WORKING, DRAINING --session_stop--> LEAVING (finishes what is traced, says BYE)
 *   any --link lost--> OFFLINE (dialled again); any --> ENDED
 *
 * Results are kept until they are acknowledged, and sent again after a reconnect to the same
 * coordinator. All functions are for the loop's thread. */
#include <stdbool.h>
#include <uv.h>

#include "worker/process/options.h"
#include "worker/process/worker_log.h"
#include "worker/session/tracing.h"

#define SESSION_GREETING_MS 10000u /* ms that a coordinator may take to answer HELLO */
#define SESSION_ACK_MS      5000u  /* ms that a leaving worker waits for acknowledgements */
/* A load that uses CPU time counts as hung after this many ms without a step. One that uses none,
 * as it waits for a disk, gets SESSION_LOADING_WAITS times as many. */
#define SESSION_LOADING_MS    120000u
#define SESSION_LOADING_WAITS 5u

enum session_state {
    SESSION_OFFLINE,
    SESSION_GREETING,
    SESSION_WORKING,
    SESSION_DRAINING, /* the coordinator gives no more tiles; a TILE ends it */
    SESSION_LEAVING,  /* the worker wants no more tiles */
    SESSION_ENDED,
    SESSION_STATE_COUNT
};

enum session_end { SESSION_END_TOLD = 0, SESSION_END_FAILED = 1, SESSION_END_REFUSED = 3 };

struct session;

struct session_client {
    void *ctx;
    struct worker_log *worker_log; /* gets a line for each event; borrowed, or NULL */
    /* The session is over; `text` says why ("" after session_stop). Call session_close. */
    void (*ended)(void *ctx, enum session_end end, const char *text);
    /* While closing: the last bytes are sent, and the threads are joined next. With is_loading this
     * may take as long as a scene loads. May be NULL. */
    void (*flushed)(void *ctx, bool is_loading);
};

/* Creates a session. It borrows `tracing` and the strings of `options` for its life. cache_dir and
 * threads must be set. *fault says what failed. */
int session_create(uv_loop_t *loop, const struct options *options, const struct tracing *tracing,
                   const struct session_client *client, struct session **out, struct fault *fault);

/* Dials the coordinator. */
void session_start(struct session *s);

/* Returns the tiles that are not begun, finishes the others, then leaves. A second call leaves at
 * once. */
void session_stop(struct session *s);

enum session_state session_state(const struct session *s);

/* Stops tracing, closes the link, joins the threads and frees the session, then calls `closed` from
 * the loop. */
void session_close(struct session *s, void (*closed)(void *ctx), void *ctx);
