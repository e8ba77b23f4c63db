#pragma once
/* The coordinator puts every room of the server together around one loop. */
#include <stdbool.h>
#include <stddef.h>

#include "proto/error.h"
#include "proto/log/log.h"
#include "server/cli/directories.h"

struct coordinator;

struct coordinator_options {
    struct log *log;                       /* must outlive the coordinator; NULL: none */
    const struct directories *directories; /* must outlive the coordinator */
    const char *listen;                    /* HTTP, "ADDR:PORT" */
    const char *tokens;            /* file (server/access/tokens.h); NULL: all clients may do all */
    unsigned tenant_jobs;          /* that have not ended, of each tenant; 0: no quota */
    unsigned tenant_assets_mib;    /* of its assets; 0: no quota */
    unsigned feed_mb_per_s;        /* of all pixel feeds while pictures are in work; 0: no limit */
    unsigned stream_share_percent; /* of the machine's CPU time, for streams; 0: no limit */
    const char *certificate, *key; /* of HTTP, PEM; NULL: no TLS */
    /* Tells that the file of tokens was read again, on SIGHUP, and how many there are now. `fault`
     * is NULL when it went well. */
    void (*reloaded)(size_t count, const struct fault *fault);
    const char *worker_key;    /* file: what workers over TCP must have; NULL: nothing */
    const char *webhook_hosts; /* that jobs may have told of their end (webhooks.h); NULL: none */
    const char *webhook_key;   /* file: what signs that */
    const char *worker_listen; /* TCP for workers; NULL: none */
    unsigned workers;          /* local ones */
    unsigned worker_threads;   /* of each */
    unsigned pool_threads;     /* reconstruction and encoding */
    bool ephemeral; /* the data folder is removed when it ends: nothing waits for the disk, no tile
                       is kept for a restart */
    bool unwatched; /* nobody looks at pictures in work (frame.h) */
};

/* Takes up unfinished jobs and listens. On failure nothing is left; *fault says what and why. */
int coordinator_create(const struct coordinator_options *options, struct coordinator **out,
                       struct fault *fault);
int coordinator_http_port(const struct coordinator *c);
int coordinator_worker_port(const struct coordinator *c); /* 0: none */

/* Serves until SIGTERM or SIGINT, then ends in order: requests in progress are answered (for 10 s
 * at most), work stops where it can go on from disk, workers leave. A second signal ends the
 * process at once. `stopping` (may be NULL) is called at the first. */
void coordinator_run(struct coordinator *c, void (*stopping)(int signal));
void coordinator_destroy(struct coordinator **c);
