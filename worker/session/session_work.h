#pragma once
/* Internals of a session, for its own files alone: session.c has its states and its life,
 * session_say.c sends messages, session_steps.c handles those that come, session_deadlines.c ends a
 * session by time. */
#include "proto/link/message.h"
#include "proto/runtime/thread_pool.h"
#include "worker/link/link.h"
#include "worker/session/blob_cache.h"
#include "worker/session/leases.h"
#include "worker/session/session.h"

enum session_deadline {
    SESSION_DEADLINE_CONNECT, /* until the first WELCOME */
    SESSION_DEADLINE_IDLE,    /* runs while no tile is held */
    SESSION_DEADLINE_LIFETIME,
    SESSION_DEADLINE_MEMORY, /* at once */
    SESSION_DEADLINE_COUNT
};

struct session {
    const struct options *options;
    const struct tracing *tracing;
    struct session_client client;
    enum session_state state;
    struct link *link;
    struct thread_pool *pool;
    struct blob_cache *cache;
    struct leases *leases;
    uv_timer_t beat, patience, deadlines[SESSION_DEADLINE_COUNT];
    uint64_t drain_ms;  /* the last part of the lifetime */
    uint64_t worker_id; /* of the last WELCOME; 0: none yet */
    uint64_t next_request;
    uint32_t beat_ms;
    uint32_t asked; /* tiles that were requested and have not come */
    bool was_told_offline;
    bool lacks_memory; /* a blob could not be loaded for want of it: the worker ends */
    /* Progress of loading: its steps so far, and the beats since the last step. Beats in which the
     * process used CPU time are counted apart. */
    uint64_t load_steps, load_silent_ms, load_busy_ms, load_beats, cpu_us;
    uint64_t last_beat_ms; /* 0: none on this link */
    unsigned open;         /* what must close before the memory goes */
    bool closing;
    void (*closed)(void *ctx);
    void *closed_ctx;
};

/* ---- session.c ---- */

/* Changes the state. An illegal transition is a bug of the worker and ends the process. */
void session_enter(struct session *s, enum session_state next);
void session_end(struct session *s, enum session_end how, const char *text);
void session_note(struct session *s, enum log_level level, const char *what, const char *detail);
/* Returns whether the coordinator has welcomed the worker and the session has not ended. */
bool session_is_on(const struct session *s);

/* ---- session_say.c ---- */

void session_ask_for_tiles(struct session *s);
void session_say_hello(struct session *s);
void session_say_goodbye(struct session *s);
/* Sends RETURNED; does nothing when the session is not on. */
void session_say_returned(struct session *s, uint64_t request_id, const struct message_returned *m);
/* Says goodbye once a leaving session has nothing left to wait for. */
void session_leave_when_done(struct session *s);
/* Asks for more tiles, or leaves, after the number of held tiles has changed. */
void session_moved(struct session *s);
void session_send_beat(struct session *s);
/* Sends beats every beat_ms from now on. */
void session_begin_beats(struct session *s);

/* ---- session_deadlines.c ---- */

void session_deadlines_init(struct session *s, uv_loop_t *loop);
void session_deadlines_start(struct session *s);
/* Tells that the coordinator has welcomed the worker. */
void session_deadlines_welcome(struct session *s);
/* Ends the session once all that waits for a blob which memory was lacking for is told of it. */
void session_deadlines_lack_memory(struct session *s);
/* Tells that the number of held tiles may have changed. */
void session_deadlines_moved(struct session *s);
void session_deadlines_stop(struct session *s);

/* ---- session_steps.c ---- */

/* Handles a message of the coordinator's. ERR_STATE for one that is not legal in this state, or
 * what its decoder returns. */
int session_take(struct session *s, const struct wire_frame_view *f);
