#pragma once
/* Local workers: child processes that are started, watched, started again when they die, and
 * stopped. The delay before a restart doubles up to 30 s while a child keeps dying. A child that
 * the coordinator refused (exit status 3) stays down, since it would be refused again. */
#include <stdint.h>
#include <uv.h>

#include "proto/error.h"
#include "proto/log/log.h"

#define PROCESSES_RETRY_MS     200u /* ms before the first restart; doubles each time */
#define PROCESSES_RETRY_MAX_MS 30000u
#define PROCESSES_HEALTHY_MS   10000u /* ms after which a child's start counts as good */
#define PROCESSES_KILL_MS      5000u  /* ms from SIGTERM to SIGKILL */

struct processes;

struct processes_options {
    const char *program;              /* path of shearwater-worker */
    const char *socket_path;          /* what it dials */
    const char *cache_dir, *blob_dir; /* may be NULL */
    unsigned count, threads;
    const struct log *log; /* whose format and least level the children's lines have; may be NULL */
    /* Tells that a child was ended from outside, by SIGKILL or another signal that programs do not
     * raise by their own faults. May be NULL. */
    void (*stopped)(void *ctx, int64_t pid);
    void *ctx;
};

/* Starts the children, at least one. Strings are copied. *fault names the program when it cannot be
 * started; *respawned is counted up with every restart and outlives the processes. */
int processes_create(uv_loop_t *loop, const struct processes_options *options, uint64_t *respawned,
                     struct processes **out, struct fault *fault);

/* Sends SIGKILL to the child with this pid, if there is one. It is started again like one that
 * died. */
void processes_end(struct processes *p, int64_t pid);

/* Sends SIGTERM to all children, and SIGKILL after 5 s. `closed` is called from the loop when all
 * are gone and freed. Must be called exactly once. */
void processes_close(struct processes *p, void (*closed)(void *ctx), void *ctx);
