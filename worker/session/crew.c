#include "worker/session/crew.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "proto/error.h"

struct crew_queue {
    struct crew_task *first, *last;
};

struct crew_thread {
    pthread_t thread;
    struct crew *crew;
    void *tracer; /* owned */
    bool started;
};

struct crew {
    const struct tracing *tracing;
    uv_poll_t results; /* of results_fd, to which whoever finishes a task writes */
    int results_fd;
    pthread_mutex_t mutex; /* guards both queues and stop */
    pthread_cond_t ready;
    struct crew_queue todo, finished;
    bool stop;
    void (*closed)(void *ctx);
    void *ctx;
    unsigned thread_count;
    struct crew_thread threads[];
};

static void push(struct crew_queue *q, struct crew_task *task)
{
    task->next = NULL;
    if (q->last)
        q->last->next = task;
    else
        q->first = task;
    q->last = task;
}

static void push_first(struct crew_queue *q, struct crew_task *task)
{
    task->next = q->first;
    q->first = task;
    if (!q->last) q->last = task;
}

static struct crew_task *pop(struct crew_queue *q)
{
    struct crew_task *task = q->first;
    if (!task) return NULL;
    q->first = task->next;
    if (!q->first) q->last = NULL;
    return task;
}

static bool take_out(struct crew_queue *q, struct crew_task *task)
{
    struct crew_task *before = NULL;
    for (struct crew_task *t = q->first; t; before = t, t = t->next) {
        if (t != task) continue;
        if (before)
            before->next = t->next;
        else
            q->first = t->next;
        if (q->last == t) q->last = before;
        return true;
    }
    return false;
}

/* The descriptor is closed only after the threads have gone. */
static void tell_loop(const struct crew *crew)
{
    const uint64_t one = 1;
    while (write(crew->results_fd, &one, sizeof one) < 0 && errno == EINTR) continue;
}

static void *work(void *arg)
{
    struct crew_thread *self = arg;
    struct crew *crew = self->crew;
    pthread_mutex_lock(&crew->mutex);
    for (;;) {
        while (!crew->stop && !crew->todo.first) pthread_cond_wait(&crew->ready, &crew->mutex);
        if (crew->stop) break;
        struct crew_task *task = pop(&crew->todo);
        pthread_mutex_unlock(&crew->mutex);
        task->run(task, self->tracer);
        pthread_mutex_lock(&crew->mutex);
        const bool first = !crew->finished.first;
        push(&crew->finished, task);
        pthread_mutex_unlock(&crew->mutex);
        if (first) tell_loop(crew);
        pthread_mutex_lock(&crew->mutex);
    }
    pthread_mutex_unlock(&crew->mutex);
    return NULL;
}

static void on_results(uv_poll_t *results, int status, int events)
{
    struct crew *crew = results->data;
    uint64_t told;
    (void)status, (void)events;
    while (read(crew->results_fd, &told, sizeof told) < 0 && errno == EINTR) continue;
    pthread_mutex_lock(&crew->mutex);
    struct crew_task *task = crew->finished.first;
    crew->finished = (struct crew_queue){0};
    pthread_mutex_unlock(&crew->mutex);
    while (task) {
        struct crew_task *next = task->next;
        task->done(task);
        task = next;
    }
}

/* Signals are the loop thread's. */
static int start_thread(struct crew *crew, struct crew_thread *t)
{
    sigset_t all, before;
    t->crew = crew;
    int e = crew->tracing->tracer_create(crew->tracing->ctx, &t->tracer);
    if (e) return e;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    t->started = pthread_create(&t->thread, NULL, work, t) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return t->started ? 0 : ERR_IO;
}

static void on_closed(uv_handle_t *handle)
{
    struct crew *crew = handle->data;
    void (*closed)(void *ctx) = crew->closed;
    void *ctx = crew->ctx;
    close(crew->results_fd);
    pthread_cond_destroy(&crew->ready);
    pthread_mutex_destroy(&crew->mutex);
    free(crew);
    if (closed) closed(ctx);
}

int crew_create(uv_loop_t *loop, const struct tracing *tracing, unsigned threads, struct crew **out)
{
    struct crew *crew = calloc(1, sizeof *crew + threads * sizeof crew->threads[0]);
    if (!crew) return ERR_MEMORY;
    crew->tracing = tracing;
    crew->thread_count = threads;
    crew->results_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (crew->results_fd < 0 || uv_poll_init(loop, &crew->results, crew->results_fd)) {
        if (crew->results_fd >= 0) close(crew->results_fd);
        free(crew);
        return ERR_IO;
    }
    crew->results.data = crew;
    pthread_mutex_init(&crew->mutex, NULL);
    pthread_cond_init(&crew->ready, NULL);
    if (uv_poll_start(&crew->results, UV_READABLE, on_results)) {
        crew_close(crew, NULL, NULL);
        return ERR_IO;
    }
    for (unsigned i = 0; i < threads; i++) {
        int e = start_thread(crew, &crew->threads[i]);
        if (e == 0) continue;
        crew_close(crew, NULL, NULL);
        return e;
    }
    *out = crew;
    return 0;
}

static void submit(struct crew *crew, struct crew_task *task,
                   void (*put)(struct crew_queue *q, struct crew_task *task))
{
    pthread_mutex_lock(&crew->mutex);
    put(&crew->todo, task);
    pthread_cond_signal(&crew->ready);
    pthread_mutex_unlock(&crew->mutex);
}

void crew_submit(struct crew *crew, struct crew_task *task)
{
    submit(crew, task, push);
}

void crew_submit_first(struct crew *crew, struct crew_task *task)
{
    submit(crew, task, push_first);
}

bool crew_withdraw(struct crew *crew, struct crew_task *task)
{
    pthread_mutex_lock(&crew->mutex);
    bool taken = take_out(&crew->todo, task);
    pthread_mutex_unlock(&crew->mutex);
    return taken;
}

void crew_close(struct crew *crew, void (*closed)(void *ctx), void *ctx)
{
    crew->closed = closed;
    crew->ctx = ctx;
    pthread_mutex_lock(&crew->mutex);
    crew->stop = true;
    pthread_cond_broadcast(&crew->ready);
    pthread_mutex_unlock(&crew->mutex);
    for (unsigned i = 0; i < crew->thread_count; i++) {
        if (crew->threads[i].started) pthread_join(crew->threads[i].thread, NULL);
        if (crew->threads[i].tracer)
            crew->tracing->tracer_destroy(crew->tracing->ctx, &crew->threads[i].tracer);
    }
    uv_close((uv_handle_t *)&crew->results, on_closed);
}
