#pragma once
/* The tracing threads: one queue of tasks, and the way back to the loop.
 *
 * All functions are called on the loop's thread. */
#include <stdbool.h>
#include <stdint.h>
#include <uv.h>

#include "worker/session/tracing.h"

struct crew;

/* Embedded in what the task is about; must live until `done`. */
struct crew_task {
    void (*run)(struct crew_task *task, void *tracer); /* on a crew thread */
    void (*done)(struct crew_task *task);              /* on the loop's thread; may free the task */
    struct crew_task *next;
};

/* ERR_MEMORY, ERR_IO. `tracing` is borrowed: each thread gets a tracer of its own. */
int crew_create(uv_loop_t *loop, const struct tracing *tracing, unsigned threads,
                struct crew **out);

/* At the end of the queue, or at its front (a scene that tiles wait for). */
void crew_submit(struct crew *crew, struct crew_task *task);
void crew_submit_first(struct crew *crew, struct crew_task *task);

/* Takes a task back that no thread has begun; false when it runs or has run: `done` comes. */
bool crew_withdraw(struct crew *crew, struct crew_task *task);

/* Waits for running tasks and joins the threads; queued tasks are dropped. `closed` comes from the
 * loop when the handle is closed and the crew freed. */
void crew_close(struct crew *crew, void (*closed)(void *ctx), void *ctx);
