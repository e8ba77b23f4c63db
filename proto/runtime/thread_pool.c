#include "proto/runtime/thread_pool.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "proto/error.h"
#include "proto/limits.h"
#include "proto/runtime/clock.h"

#define NAME_BYTES 16 /* what the kernel keeps of a thread's name, with its end */

/* A list with its last element known. */
struct pool_queue {
    struct pool_task *first, *last;
};

struct pool_thread {
    pthread_t thread;
    struct thread_pool *pool;
    void *tool;      /* owned */
    uint64_t cpu_us; /* when its last task ended, on its own clock */
    bool started;
};

struct thread_pool {
    /* Polls results_fd, to which a thread writes when it has finished a task. uv_async would let
     * the loop spin for as long as its sender is kept off the CPU (libuv 1.44). */
    uv_poll_t results;
    int results_fd;
    char name[NAME_BYTES];
    struct pool_tools tools;
    unsigned pending; /* the loop's thread alone */
    void (*closed)(void *ctx);
    void *ctx;

    pthread_mutex_t mutex; /* guards all below */
    pthread_cond_t work;   /* something is queued, or stop */
    pthread_cond_t result; /* something is finished */
    struct pool_queue queued, finished;
    bool stop;

    unsigned thread_count;
    struct pool_thread threads[];
};

/* -- the queue -- */

static void queue_push(struct pool_queue *q, struct pool_task *task)
{
    task->next = NULL;
    if (q->last)
        q->last->next = task;
    else
        q->first = task;
    q->last = task;
}

static void queue_push_first(struct pool_queue *q, struct pool_task *task)
{
    task->next = q->first;
    q->first = task;
    if (!q->last) q->last = task;
}

static struct pool_task *queue_pop(struct pool_queue *q)
{
    struct pool_task *task = q->first;
    if (!task) return NULL;
    q->first = task->next;
    if (!q->first) q->last = NULL;
    task->next = NULL;
    return task;
}

static bool queue_remove(struct pool_queue *q, struct pool_task *task)
{
    struct pool_task *before = NULL, *t = q->first;
    for (; t && t != task; t = t->next) before = t;
    if (!t) return false;
    if (before)
        before->next = t->next;
    else
        q->first = t->next;
    if (q->last == t) q->last = before;
    return true;
}

/* -- on the threads -- */

/* Counts from where the task before ended, since a clock of CPU time is a call of the system. */
static void run_task(struct pool_thread *self, struct pool_task *task)
{
    const uint64_t start_us = self->cpu_us;
    task->tool = self->tool;
    task->run(task);
    self->cpu_us = thread_cpu_us();
    task->cpu_us = self->cpu_us - start_us;
}

/* The descriptor is closed only after the threads have gone. */
static void tell_loop(const struct thread_pool *pool)
{
    const uint64_t one = 1;
    while (write(pool->results_fd, &one, sizeof one) < 0 && errno == EINTR) continue;
}

static void finish_task(struct thread_pool *pool, struct pool_task *task)
{
    pthread_mutex_lock(&pool->mutex);
    const bool first = !pool->finished.first;
    queue_push(&pool->finished, task);
    pthread_cond_signal(&pool->result);
    pthread_mutex_unlock(&pool->mutex);
    if (first) tell_loop(pool);
}

/* Waits for a task; NULL: stop. */
static struct pool_task *next_task(struct thread_pool *pool)
{
    pthread_mutex_lock(&pool->mutex);
    while (!pool->stop && !pool->queued.first) pthread_cond_wait(&pool->work, &pool->mutex);
    struct pool_task *task = pool->stop ? NULL : queue_pop(&pool->queued);
    pthread_mutex_unlock(&pool->mutex);
    return task;
}

static void *thread_main(void *arg)
{
    struct pool_thread *self = arg;
    struct pool_task *task;
    pthread_setname_np(pthread_self(), self->pool->name);
    while ((task = next_task(self->pool))) {
        run_task(self, task);
        finish_task(self->pool, task);
    }
    return NULL;
}

/* -- on the loop -- */

static void count_up(struct thread_pool *pool)
{
    if (pool->pending++ == 0) uv_ref((uv_handle_t *)&pool->results);
}

static void count_down(struct thread_pool *pool)
{
    if (--pool->pending == 0) uv_unref((uv_handle_t *)&pool->results);
}

/* Calls the done functions of what is finished, in the order of completion. */
static void drain(struct thread_pool *pool)
{
    pthread_mutex_lock(&pool->mutex);
    struct pool_queue finished = pool->finished;
    pool->finished = (struct pool_queue){0};
    pthread_mutex_unlock(&pool->mutex);
    struct pool_task *task;
    while ((task = queue_pop(&finished))) {
        count_down(pool); /* before done, so that the task's own done sees itself as gone */
        if (task->done) task->done(task);
    }
}

static void on_results(uv_poll_t *results, int status, int events)
{
    struct thread_pool *pool = results->data;
    uint64_t told;
    (void)status, (void)events;
    while (read(pool->results_fd, &told, sizeof told) < 0 && errno == EINTR) continue;
    drain(pool);
}

static void free_pool(struct thread_pool *pool)
{
    if (pool->results_fd >= 0) close(pool->results_fd);
    pthread_cond_destroy(&pool->result);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->mutex);
    free(pool);
}

static void on_close(uv_handle_t *handle)
{
    struct thread_pool *pool = handle->data;
    void (*closed)(void *ctx) = pool->closed;
    void *ctx = pool->ctx;
    free_pool(pool);
    if (closed) closed(ctx);
}

static int start_thread(struct thread_pool *pool, struct pool_thread *t)
{
    const struct pool_tools *tools = &pool->tools;
    sigset_t all, before;
    t->pool = pool;
    const int error = tools->create ? tools->create(tools->ctx, &t->tool) : 0;
    if (error) return error;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    t->started = pthread_create(&t->thread, NULL, thread_main, t) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return t->started ? 0 : ERR_IO;
}

static int start(struct thread_pool *pool)
{
    if (uv_poll_start(&pool->results, UV_READABLE, on_results)) return ERR_IO;
    uv_unref((uv_handle_t *)&pool->results); /* until there is work */
    int error = 0;
    for (unsigned i = 0; !error && i < pool->thread_count; i++)
        error = start_thread(pool, &pool->threads[i]);
    return error;
}

int thread_pool_create(uv_loop_t *loop, const char *name, unsigned threads,
                       const struct pool_tools *tools, struct thread_pool **out)
{
    *out = NULL;
    if (threads == 0) threads = 1;
    if (threads > LIMIT_THREADS) return ERR_LIMIT;
    struct thread_pool *pool = calloc(1, sizeof *pool + threads * sizeof pool->threads[0]);
    if (!pool) return ERR_MEMORY;
    strncpy(pool->name, name, NAME_BYTES - 1);
    if (tools) pool->tools = *tools;
    pool->thread_count = threads;
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->result, NULL);
    pool->results_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (pool->results_fd < 0 || uv_poll_init(loop, &pool->results, pool->results_fd)) {
        free_pool(pool);
        return ERR_IO;
    }
    pool->results.data = pool;
    const int error = start(pool);
    if (error)
        thread_pool_close(&pool, NULL, NULL);
    else
        *out = pool;
    return error;
}

static void submit(struct thread_pool *pool, struct pool_task *task,
                   void (*put)(struct pool_queue *q, struct pool_task *task))
{
    count_up(pool);
    task->cpu_us = 0;
    pthread_mutex_lock(&pool->mutex);
    put(&pool->queued, task);
    pthread_cond_signal(&pool->work);
    pthread_mutex_unlock(&pool->mutex);
}

void thread_pool_submit(struct thread_pool *pool, struct pool_task *task)
{
    submit(pool, task, queue_push);
}

void thread_pool_submit_first(struct thread_pool *pool, struct pool_task *task)
{
    submit(pool, task, queue_push_first);
}

bool thread_pool_withdraw(struct thread_pool *pool, struct pool_task *task)
{
    pthread_mutex_lock(&pool->mutex);
    const bool taken = queue_remove(&pool->queued, task);
    pthread_mutex_unlock(&pool->mutex);
    if (taken) count_down(pool);
    return taken;
}

unsigned thread_pool_threads(const struct thread_pool *pool)
{
    return pool->thread_count;
}

unsigned thread_pool_pending(const struct thread_pool *pool)
{
    return pool->pending;
}

void thread_pool_destroy(struct thread_pool **out)
{
    struct thread_pool *pool = *out;
    if (!pool) return;
    /* Done functions may submit more: until nothing is left. */
    while (pool->pending > 0) {
        pthread_mutex_lock(&pool->mutex);
        while (!pool->finished.first) pthread_cond_wait(&pool->result, &pool->mutex);
        pthread_mutex_unlock(&pool->mutex);
        drain(pool);
    }
    thread_pool_close(out, NULL, NULL);
}

static void join_thread(const struct pool_tools *tools, struct pool_thread *t)
{
    if (t->started) pthread_join(t->thread, NULL);
    if (t->tool) tools->destroy(tools->ctx, &t->tool);
}

void thread_pool_close(struct thread_pool **out, void (*closed)(void *ctx), void *ctx)
{
    struct thread_pool *pool = *out;
    *out = NULL;
    pool->closed = closed;
    pool->ctx = ctx;
    pthread_mutex_lock(&pool->mutex);
    pool->stop = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->mutex);
    for (unsigned i = 0; i < pool->thread_count; i++) join_thread(&pool->tools, &pool->threads[i]);
    uv_close((uv_handle_t *)&pool->results, on_close);
}
