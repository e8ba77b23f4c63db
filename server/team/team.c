#include "server/team/team.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "proto/error.h"

#define NAME_BYTES 16 /* what the kernel keeps of a thread's name, with its end */

/* A list with its last element known. */
struct task_queue {
    struct team_task *first, *last;
};

struct team {
    uv_loop_t *loop;
    /* Of results_fd, to which whoever finishes something writes: uv_async has the loop spin for as
     * long as its sender is kept off the CPU (libuv 1.44). */
    uv_poll_t results;
    int results_fd;
    char name[NAME_BYTES];
    unsigned pending; /* the loop's thread alone */

    pthread_mutex_t mutex; /* guards all below */
    pthread_cond_t work;   /* something is queued, or stop */
    pthread_cond_t result; /* something is finished */
    struct task_queue queued, finished;
    bool stop;

    unsigned thread_count;
    pthread_t threads[];
};

static void queue_push(struct task_queue *q, struct team_task *task)
{
    task->next = NULL;
    if (q->last)
        q->last->next = task;
    else
        q->first = task;
    q->last = task;
}

static struct team_task *queue_pop(struct task_queue *q)
{
    struct team_task *task = q->first;
    if (!task) return NULL;
    q->first = task->next;
    if (!q->first) q->last = NULL;
    task->next = NULL;
    return task;
}

static uint64_t thread_cpu_us(void)
{
    struct timespec t;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t)) return 0;
    return (uint64_t)t.tv_sec * 1000000u + (uint64_t)t.tv_nsec / 1000u;
}

static void run_task(struct team_task *task)
{
    uint64_t start_us = thread_cpu_us();
    task->run(task);
    task->cpu_us = thread_cpu_us() - start_us;
}

/* The descriptor is closed only after the threads have gone. */
static void tell_loop(const struct team *team)
{
    const uint64_t one = 1;
    while (write(team->results_fd, &one, sizeof one) < 0 && errno == EINTR) continue;
}

static void *thread_main(void *arg)
{
    struct team *team = arg;
    pthread_setname_np(pthread_self(), team->name);
    pthread_mutex_lock(&team->mutex);
    for (;;) {
        struct team_task *task = queue_pop(&team->queued);
        if (task) {
            pthread_mutex_unlock(&team->mutex);
            run_task(task);
            pthread_mutex_lock(&team->mutex);
            const bool first = !team->finished.first;
            queue_push(&team->finished, task);
            pthread_cond_signal(&team->result);
            pthread_mutex_unlock(&team->mutex);
            if (first) tell_loop(team);
            pthread_mutex_lock(&team->mutex);
        } else if (team->stop) {
            break;
        } else {
            pthread_cond_wait(&team->work, &team->mutex);
        }
    }
    pthread_mutex_unlock(&team->mutex);
    return NULL;
}

/* Calls the done functions of what is finished, in the order of completion. */
static void drain(struct team *team)
{
    pthread_mutex_lock(&team->mutex);
    struct task_queue finished = team->finished;
    team->finished = (struct task_queue){0};
    pthread_mutex_unlock(&team->mutex);
    struct team_task *task;
    while ((task = queue_pop(&finished))) {
        /* Before done, so that the task's own done sees itself as gone. */
        if (--team->pending == 0) uv_unref((uv_handle_t *)&team->results);
        if (task->done) task->done(task);
    }
}

static void on_results(uv_poll_t *results, int status, int events)
{
    struct team *team = results->data;
    uint64_t told;
    (void)status, (void)events;
    while (read(team->results_fd, &told, sizeof told) < 0 && errno == EINTR) continue;
    drain(team);
}

static void join_threads(struct team *team)
{
    pthread_mutex_lock(&team->mutex);
    team->stop = true;
    pthread_cond_broadcast(&team->work);
    pthread_mutex_unlock(&team->mutex);
    for (unsigned i = 0; i < team->thread_count; i++) pthread_join(team->threads[i], NULL);
}

static void free_team(struct team *team)
{
    if (team->results_fd >= 0) close(team->results_fd);
    pthread_cond_destroy(&team->result);
    pthread_cond_destroy(&team->work);
    pthread_mutex_destroy(&team->mutex);
    free(team);
}

static void on_close(uv_handle_t *handle)
{
    free_team(handle->data);
}

static void close_handle(struct team *team)
{
    uv_close((uv_handle_t *)&team->results, on_close);
}

static int start_threads(struct team *team, unsigned threads)
{
    for (; team->thread_count < threads; team->thread_count++) {
        if (pthread_create(&team->threads[team->thread_count], NULL, thread_main, team)) {
            join_threads(team);
            return ERR_IO;
        }
    }
    return 0;
}

int team_create(uv_loop_t *loop, const char *name, unsigned threads, struct team **out)
{
    *out = NULL;
    if (threads == 0) threads = 1;
    if (threads > LIMIT_THREADS) return ERR_LIMIT;
    struct team *team = calloc(1, sizeof *team + threads * sizeof team->threads[0]);
    if (!team) return ERR_MEMORY;
    team->loop = loop;
    strncpy(team->name, name, NAME_BYTES - 1);
    pthread_mutex_init(&team->mutex, NULL);
    pthread_cond_init(&team->work, NULL);
    pthread_cond_init(&team->result, NULL);
    team->results_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (team->results_fd < 0 || uv_poll_init(loop, &team->results, team->results_fd)) {
        free_team(team);
        return ERR_IO;
    }
    team->results.data = team;
    int error = uv_poll_start(&team->results, UV_READABLE, on_results) ? ERR_IO : 0;
    /* An idle team does not keep the loop running; one with work does. */
    uv_unref((uv_handle_t *)&team->results);
    if (!error) error = start_threads(team, threads);
    if (error) {
        close_handle(team);
        return error;
    }
    *out = team;
    return 0;
}

void team_submit(struct team *team, struct team_task *task)
{
    if (team->pending++ == 0) uv_ref((uv_handle_t *)&team->results);
    task->cpu_us = 0;
    pthread_mutex_lock(&team->mutex);
    queue_push(&team->queued, task);
    pthread_cond_signal(&team->work);
    pthread_mutex_unlock(&team->mutex);
}

unsigned team_pending(const struct team *team)
{
    return team->pending;
}

void team_destroy(struct team **out)
{
    struct team *team = *out;
    if (!team) return;
    /* Done functions may submit more: until nothing is left. */
    while (team->pending > 0) {
        pthread_mutex_lock(&team->mutex);
        while (!team->finished.first) pthread_cond_wait(&team->result, &team->mutex);
        pthread_mutex_unlock(&team->mutex);
        drain(team);
    }
    join_threads(team);
    close_handle(team);
    *out = NULL;
}
