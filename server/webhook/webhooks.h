#pragma once
/* Tells other programs that a job has ended: one POST to the address that the job gives, if its
 * operator allows the host.
 *
 *   Shearwater-Timestamp: seconds since 1970
 *   Shearwater-Signature: sha256=HMAC-SHA256(key, timestamp "." body) as hexadecimal digits
 *   {"id": ..., "name": text or null, "state": ..., "links": {"job": path, "page": path,
 *    "thumbnail": path}}
 *
 * What waits is in the store, so it outlives this process. A try that is not answered 2xx in time
 * is repeated, each time after a longer pause, until WEBHOOK_TRIES have failed. Redirects are
 * not followed, proxies not asked. All of it runs on the loop's thread and never waits. */
#include <uv.h>

#include "proto/log/log.h"
#include "server/store/job_store.h"

#define WEBHOOK_TRIES 8

struct webhooks;

struct webhooks_options {
    uv_loop_t *loop;
    struct log *log; /* may be NULL */
    struct job_store *store;
    const char *hosts;    /* webhook_hosts.h */
    const char *key_path; /* link_key.h */
};

/* Begins with what waits in the store. *fault says what is wrong with the hosts or the key. */
int webhooks_create(const struct webhooks_options *options, struct webhooks **out,
                    struct fault *fault);
/* Ends what is on its way, which is tried again after a start. The loop must run once more before
 * destroy. Both ignore NULL. */
void webhooks_stop(struct webhooks *w);
void webhooks_destroy(struct webhooks **w);

/* Checks a job's address. w NULL: no host is allowed. ERR_UNSUPPORTED, ERR_SYNTAX. */
int webhooks_check(const struct webhooks *w, const char *url, struct fault *fault);

/* Looks for jobs that have ended. NULL is ignored. */
void webhooks_soon(struct webhooks *w);

struct webhooks_totals {
    uint64_t delivered, failed, given_up; /* failed: tries that are repeated */
    uint64_t in_flight;
};
void webhooks_totals(const struct webhooks *w, struct webhooks_totals *out);
