#pragma once
/* The fleet from inside: for fleet.c, fleet_host.c, dispatch.c and quarantine.c alone. */
#include "server/fleet/fleet.h"
#include "server/fleet/lease.h"
#include "server/fleet/listener.h"
#include "server/fleet/processes.h"
#include "server/fleet/schedule.h"
#include "server/fleet/session.h"

/* A worker that may have died: its link broke while it held tiles. */
struct gone {
    char name[LIMIT_NAME_BYTES];
    uint64_t pid, id; /* id 0: the entry is empty */
    bool local;
};
#define STOPPED_KNOWN 64
#define GONE_KNOWN    256 /* a worker that comes back after more than that many counts as dead */

struct fleet {
    uv_loop_t *loop;
    struct fleet_client client;
    struct log *log; /* borrowed; may be NULL */
    uint32_t beat_ms, silence_ms, stall_ms;
    struct session_host host;
    struct session **sessions; /* owned, by growing id */
    size_t session_count, session_capacity;
    struct schedule_worker *offers; /* owned scratch of dispatch.c, session_capacity long each */
    struct session **offered;
    uint32_t *give;
    const struct lease_table **tables;
    uint64_t next_id;
    size_t unacked_bytes;
    char embree_version[LIMIT_NAME_BYTES]; /* of the first worker; "" before it */
    struct fleet_totals totals;
    struct lease_past past;
    struct worker_health health;
    struct gone gone[GONE_KNOWN];
    unsigned gone_next;
    int64_t
        stopped[STOPPED_KNOWN]; /* local processes that were stopped from outside, the last ones */
    unsigned stopped_next;
    uv_idle_t turn; /* active: on_turn is due before the loop sleeps */
    uv_timer_t tick;
    uv_timer_t speculation; /* active: a worker idles while others have tiles */
    struct listener local, tcp;
    struct processes *processes;
    bool closing;
    struct link_key key; /* of links over TCP, if they are keyed */
    bool keyed;
    unsigned open; /* handles, sessions and processes that are not released yet */
    void (*closed)(void *ctx);
    void *closed_ctx;
};

/* Returns what the fleet's sessions call. `closed` is called when one has gone. */
struct session_host fleet_host(struct fleet *fleet, void (*closed)(void *ctx, struct session *s));

/* Gives tiles to workers that want them. When there are none, idle workers get copies of late
 * tiles. */
void fleet_dispatch(struct fleet *fleet);

struct session *fleet_find_session(const struct fleet *fleet, uint64_t id); /* NULL: none */
/* Serves session_host: takes note of a worker that may have died. */
bool fleet_note_gone(void *fleet, const struct session *s);
/* Tells the client when such a worker joins again, or was a local process that was stopped from
 * outside. */
void fleet_note_joined(struct fleet *fleet, const struct session *s);
void fleet_note_stopped(void *fleet, int64_t pid);
/* Serves session_host: kills a silent local process, which is then started again. */
void fleet_note_silent(void *fleet, const struct session *s);
/* Serves session_host. */
void fleet_struck(void *fleet, struct session *s, enum strike kind);
