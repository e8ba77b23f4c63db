#pragma once
/* A pool of threads with one queue of tasks, and the way back to the loop.
 *
 * A task is a pair of functions: `run` on one of the threads, then `done` on the loop's thread. A
 * pool of one thread is a strict queue. All functions here are called on the loop's thread only. A
 * pool with pending tasks keeps uv_run going, an idle one does not. */
#include <stdbool.h>
#include <uv.h>

struct thread_pool;

/* The caller embeds this in its own struct; memory stays the caller's and must live until `done`
 * was called. */
struct pool_task {
    void (*run)(struct pool_task *task); /* on a thread of the pool */
    void (*done)(
        struct pool_task *task); /* on the loop's thread; may free the task; NULL: nothing */
    struct pool_task *next;
    void *tool;      /* the thread's own, filled in before run */
    uint64_t cpu_us; /* CPU time of run, filled in before done */
};

/* What each thread works with. `create` returns an error code, and is called before the thread
 * starts; `destroy`, after it has ended. */
struct pool_tools {
    int (*create)(void *ctx, void **tool);
    void (*destroy)(void *ctx, void **tool);
    void *ctx;
};

/* Starts the threads, which take no signals. `name` is shown by tools such as top (at most 15
 * bytes); `tools` may be NULL. ERR_LIMIT, ERR_MEMORY, ERR_IO, or what tools->create returned; then
 * the loop must run once more to close the pool's handle. */
int thread_pool_create(uv_loop_t *loop, const char *name, unsigned threads,
                       const struct pool_tools *tools, struct thread_pool **out);

/* Puts a task at the end of the queue, or at its front. */
void thread_pool_submit(struct thread_pool *pool, struct pool_task *task);
void thread_pool_submit_first(struct thread_pool *pool, struct pool_task *task);

/* Takes a task back that no thread has begun. False: it runs or has run, and `done` will be
 * called. */
bool thread_pool_withdraw(struct thread_pool *pool, struct pool_task *task);

/* Returns how many tasks were submitted and are not yet done. */
/* Returns how many threads it has. */
unsigned thread_pool_threads(const struct thread_pool *pool);
unsigned thread_pool_pending(const struct thread_pool *pool);

/* Lets queued tasks run, calls their done functions and joins the threads; afterwards the loop must
 * run once more to close the pool's handle. Nulls the pointer. */
void thread_pool_destroy(struct thread_pool **pool);

/* Waits for running tasks only and joins the threads; no done function is called any more. `closed`
 * (may be NULL) comes from the loop when the handle is closed and the pool freed. Nulls the
 * pointer. */
void thread_pool_close(struct thread_pool **pool, void (*closed)(void *ctx), void *ctx);
