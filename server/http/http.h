#pragma once
/* The HTTP side: MHD inside the uv loop, one file per resource. */
#include <uv.h>

#include "proto/log/log.h"
#include "server/fleet/fleet.h"
#include "server/job/jobs.h"
#include "server/store/objects.h"
#include "server/stream/stream.h"

struct http;

struct http_options {
    uv_loop_t *loop;
    struct log *log;    /* takes requests and their answers; NULL: none */
    const char *listen; /* "ADDR:PORT"; beyond loopback only with tokens and TLS; port 0: any */
    const char *tokens_path;                 /* NULL: all clients may do everything */
    const char *certificate_path, *key_path; /* PEM; NULL: no TLS */
    const char *web_dir;                     /* the viewer's files */
    const char *openapi_path;
    const struct objects *objects;
    struct job_store *store;     /* for assets, and for metrics */
    const struct spools *spools; /* for metrics */
    struct webhooks *webhooks;   /* for metrics; may be NULL */
    struct thread_pool *pool;    /* hashing uploads, encoding pictures; NULL: after http_stop */
    struct jobs *jobs;
    struct fleet *fleet;
    struct streams *streams;
    int64_t feed_bytes_per_s; /* of all pixel feeds while pictures are in work; 0: no limit */
    int64_t stream_us_per_s;  /* of CPU time that streams may take; 0: no limit */
};

/* Creates the server and listens. *fault says why an address was refused. */
int http_create(const struct http_options *options, struct http **out, struct fault *fault);
int http_port(const struct http *http);

/* Reads the file of tokens again. Answers under way that their user may not have any more are cut
 * off. On failure the tokens from before stay. *count: how many there are. */
int http_reload_tokens(struct http *http, size_t *count, struct fault *fault);

/* Answers new requests with 503 (but /livez, /readyz and /metrics), and ends streams. Then
 * http_destroy must follow, after which the loop must run once more. The process ignores SIGPIPE.
 * streams must outlive it. */
void http_drain(struct http *http);
/* Returns the number of requests whose answers have not gone out. */
unsigned http_in_work(const struct http *http);
/* Returns the number of connections that are open, or closed and lingering (linger.h). */
unsigned http_connections(const struct http *http);
/* Begins no more work for the pool, which goes before the rest. */
void http_stop(struct http *http);
void http_destroy(struct http **http);
