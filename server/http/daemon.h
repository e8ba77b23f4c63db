#pragma once
/* MHD inside the uv loop: what request handlers share. */
#include <microhttpd.h>
#include <uv.h>

#include "server/http/access.h"
#include "server/http/held.h"
#include "server/http/http.h"
#include "server/http/lingering.h"
#include "server/http/readiness.h"
#include "server/http/request_count.h"
#include "server/http/tls.h"

struct request;
struct static_files;

/* A connection, and the time until which the request on it must have arrived (or its answer gone).
 */
struct peer {
    struct peer *next, **link;
    struct http *http;
    int fd;
    uint64_t deadline_ms;    /* of the loop's clock; 0: none */
    struct request *request; /* in work; NULL between requests */
    bool cut;                /* shut down for want of room */
    bool served;             /* the last request was answered by its handler */
};

struct http {
    struct http_options options; /* pointers to other rooms; texts are not kept */
    struct MHD_Daemon *mhd;
    uv_poll_t poll;  /* MHD's epoll descriptor */
    uv_timer_t run;  /* when MHD wants to run again, or has been kicked */
    uv_timer_t tick; /* deadlines, heartbeats */
    uv_timer_t pace; /* turns of feeds, while some wait for one */
    int open_handles;
    int port;
    bool draining;
    uint64_t request_ms, upload_ms;
    uint64_t started_s; /* since 1970 */
    uint64_t start_ns;  /* tells tags of this life from another's */
    struct peer *peers;
    struct request *requests;
    struct static_files *files;
    unsigned connections, connections_most, uploads, encodings;
    uint64_t connections_cut; /* crowd.h */
    size_t body_bytes;        /* of all requests */
    uint64_t log_lines;       /* messages of MHD: counted, not printed */
    struct lingering lingering;
    struct access access;
    struct tls tls; /* texts NULL: none */
    struct readiness readiness;
    struct held held;
    struct request_count count;
    uint64_t tick_ns;                 /* when the last one came; 0: none yet */
    struct duration_histogram delays; /* of ticks, after their time */
    struct trace_source traces;
};

/* MHD has something to do: it runs before the loop sleeps. */
void http_kick(struct http *http);

/* One of open_handles has gone; with the last of a destroyed one it is freed. */
void http_release(struct http *http);

/* Sets the connection's deadline; 0 ms: none. */
void peer_deadline(struct peer *peer, uint64_t ms);

/* Sends a bare problem answer past MHD and shuts the connection: for requests that MHD lets nobody
 * answer because their body has not ended. */
void peer_abort(struct peer *peer, unsigned status);
