#pragma once
/* A team of threads with one queue, and the way back to the loop.
 *
 * Work is a pair of functions: `run` on one of the team's threads, then `done` on the loop's
 * thread. A team of one thread is a strict queue: the store uses it so. Everything here is called
 * on the loop's thread only. A team with pending tasks keeps uv_run going, an idle one does not. */
#include <uv.h>

struct team;

/* The caller embeds this first in its own struct; memory stays the caller's and must live until
 * `done` was called. */
struct team_task {
    void (*run)(struct team_task *task); /* on a team thread */
    void (*done)(
        struct team_task *task); /* on the loop's thread; may free the task; NULL: nothing */
    struct team_task *next;
    uint64_t cpu_us; /* CPU time of run, filled in before done */
};

/* name: for people who look at threads (at most 15 bytes). ERR_MEMORY, ERR_IO. */
int team_create(uv_loop_t *loop, const char *name, unsigned threads, struct team **out);
void team_submit(struct team *team, struct team_task *task);

/* Tasks submitted and not yet done. */
unsigned team_pending(const struct team *team);

/* Lets queued tasks run, calls their done functions, joins the threads; afterwards the loop must
 * run once more to close the team's handle. Nulls the pointer. */
void team_destroy(struct team **team);
