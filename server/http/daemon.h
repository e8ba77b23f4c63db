#pragma once
/* MHD inside the uv loop, and what request handlers share. */
#include <microhttpd.h>
#include <uv.h>

#include "server/http/access.h"
#include "server/http/connection.h"
#include "server/http/connection/linger.h"
#include "server/http/connection/tls.h"
#include "server/http/http.h"
#include "server/http/pending.h"
#include "server/http/readiness.h"
#include "server/http/request_count.h"

struct static_files;

struct http {
    struct http_options options; /* pointers to other rooms; texts are not kept */
    struct MHD_Daemon *mhd;
    uv_poll_t poll;        /* MHD's epoll descriptor */
    uv_idle_t turn;        /* active: MHD runs before the loop sleeps, once a turn of it */
    uv_timer_t run;        /* when MHD wants to run again */
    uv_timer_t tick;       /* deadlines, heartbeats */
    uv_timer_t rate_limit; /* turns of feeds, while some wait for one */
    int open_handles;
    int port;
    bool draining;
    uint64_t request_ms, upload_ms;
    uint64_t started_s; /* since 1970 */
    uint64_t start_ns;  /* tells entity tags of this run from those of others */
    struct connection *open;
    struct request *requests;
    struct static_files *files;
    unsigned connections, connections_max, encodings;
    unsigned uploads;         /* under way, also when their client has left (upload.h) */
    uint64_t connections_cut; /* connection_limits.h */
    size_t body_room_bytes;   /* for bodies, of all requests */
    uint64_t log_lines;       /* messages of MHD: counted, not printed */
    struct linger_list linger;
    struct access access;
    struct tls tls; /* texts NULL: none */
    struct readiness readiness;
    struct pending pending;
    struct request_count count;
    uint64_t tick_ns;                 /* time of the last tick; 0: none yet */
    struct duration_histogram delays; /* of ticks, after their time */
    struct trace_context_source traces;
};

/* Lets MHD run before the loop sleeps. */
void http_kick(struct http *http);

/* Counts one of open_handles less. The last one frees a destroyed server. */
void http_release(struct http *http);
