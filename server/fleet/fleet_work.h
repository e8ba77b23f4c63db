#pragma once
/* The fleet from inside: for fleet.c and hand_out.c alone. */
#include "server/fleet/fleet.h"
#include "server/fleet/lease.h"
#include "server/fleet/listener.h"
#include "server/fleet/processes.h"
#include "server/fleet/schedule.h"
#include "server/fleet/session.h"

struct fleet {
    uv_loop_t *loop;
    struct fleet_client client;
    uint32_t beat_ms, silence_ms, stall_ms;
    struct session_host host;
    struct session **sessions; /* owned, by growing id */
    size_t session_count, session_capacity;
    struct schedule_worker *offers; /* owned scratch of hand_out, session_capacity long each */
    struct session **offered;
    uint32_t *give;
    const struct lease_table **tables;
    uint64_t next_id;
    size_t unacked_bytes;
    char embree_version[LIMIT_NAME_BYTES]; /* of the first worker; "" before it */
    struct fleet_totals totals;
    struct lease_past past;
    uv_idle_t turn; /* active: on_turn is due before the loop sleeps */
    uv_timer_t tick;
    uv_timer_t late; /* active: somebody idles while others have tiles */
    struct listener local, tcp;
    struct processes *processes;
    bool closing;
    struct link_key key; /* of links over TCP, if they are keyed */
    bool keyed;
    unsigned open; /* handles, sessions and processes that are not released yet */
    void (*closed)(void *ctx);
    void *closed_ctx;
};

/* Gives tiles to those who want them; to those who idle when there are none, copies of tiles that
 * others are late with. */
void fleet_hand_out(struct fleet *fleet);
