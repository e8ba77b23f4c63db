#include "proto/log/log_writer.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "proto/log/log.h"

#define TRY_AGAIN_MS 100

struct log_writer {
    pthread_t thread;
    pthread_mutex_t lock; /* before all that follows but fd and piece */
    pthread_cond_t filled, emptied;
    uint64_t put_bytes, taken_bytes; /* since the start; the rest is in bytes, round and round */
    uint64_t failed;                 /* lines */
    bool writing, ending, left;      /* left: log_writer_close no longer waits */
    int fd;
    char piece[LOG_LINE_BYTES];
    char bytes[LOG_BUFFER_BYTES];
};

static void release(struct log_writer *w)
{
    pthread_cond_destroy(&w->emptied);
    pthread_cond_destroy(&w->filled);
    pthread_mutex_destroy(&w->lock);
    free(w);
}

/* -- on the writer's thread -- */

/* Returns whether an error may pass, as when a user makes room on the disk. */
static bool may_pass(int error)
{
    return error == ENOSPC || error == EDQUOT || error == EIO;
}

static void wait_for_better(int fd, int error)
{
    const struct timespec pause = {.tv_nsec = TRY_AGAIN_MS * 1000000};
    struct pollfd p = {.fd = fd, .events = POLLOUT};
    if (error == EAGAIN) (void)poll(&p, 1, -1);
    if (may_pass(error)) (void)nanosleep(&pause, NULL);
}

/* Writes a text. Returns the bytes that were written, fewer than all after an error that stays. */
static size_t write_all(int fd, const char *text, size_t size_bytes)
{
    size_t done_bytes = 0;
    while (done_bytes < size_bytes) {
        const ssize_t n = write(fd, text + done_bytes, size_bytes - done_bytes);
        if (n < 0 && errno != EINTR && errno != EAGAIN && !may_pass(errno)) break;
        if (n < 0)
            wait_for_better(fd, errno);
        else
            done_bytes += (size_t)n;
    }
    return done_bytes;
}

/* Writes whole lines; returns how many of them were not. */
static uint64_t write_piece(const struct log_writer *w, size_t size_bytes)
{
    uint64_t failed = 0;
    for (size_t i = write_all(w->fd, w->piece, size_bytes); i < size_bytes; i++)
        failed += w->piece[i] == '\n';
    return failed;
}

/* Takes as many whole lines as fit into a piece. */
static size_t take_piece(struct log_writer *w)
{
    const size_t waiting = (size_t)(w->put_bytes - w->taken_bytes);
    size_t size_bytes = waiting < sizeof w->piece ? waiting : sizeof w->piece;
    const size_t from = (size_t)(w->taken_bytes % LOG_BUFFER_BYTES);
    const size_t first =
        size_bytes < LOG_BUFFER_BYTES - from ? size_bytes : LOG_BUFFER_BYTES - from;
    memcpy(w->piece, w->bytes + from, first);
    memcpy(w->piece + first, w->bytes, size_bytes - first);
    while (w->piece[size_bytes - 1] != '\n') size_bytes--;
    w->taken_bytes += size_bytes;
    return size_bytes;
}

static void *run(void *ctx)
{
    struct log_writer *w = ctx;
    pthread_mutex_lock(&w->lock);
    while (!w->ending || w->put_bytes > w->taken_bytes) {
        if (w->put_bytes == w->taken_bytes) {
            pthread_cond_wait(&w->filled, &w->lock);
            continue;
        }
        const size_t size_bytes = take_piece(w);
        w->writing = true;
        pthread_mutex_unlock(&w->lock);
        const uint64_t failed = write_piece(w, size_bytes);
        pthread_mutex_lock(&w->lock);
        w->writing = false;
        w->failed += failed;
        if (w->put_bytes == w->taken_bytes) pthread_cond_signal(&w->emptied);
    }
    const bool left = w->left;
    pthread_mutex_unlock(&w->lock);
    if (left) release(w);
    return NULL;
}

/* -- on the caller's thread -- */

/* Starts the thread with signals blocked, since other threads handle them. */
static int start(struct log_writer *w)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const int error = pthread_create(&w->thread, NULL, run, w);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

struct log_writer *log_writer_create(int fd)
{
    struct log_writer *w = calloc(1, sizeof *w);
    pthread_condattr_t monotonic;
    if (!w) return NULL;
    w->fd = fd;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->filled, NULL);
    pthread_cond_init(&w->emptied, &monotonic);
    pthread_condattr_destroy(&monotonic);
    if (start(w) == 0) return w;
    release(w);
    return NULL;
}

bool log_writer_put(struct log_writer *w, const char *line, size_t size_bytes)
{
    pthread_mutex_lock(&w->lock);
    const bool room = size_bytes <= LOG_BUFFER_BYTES - (w->put_bytes - w->taken_bytes);
    if (room) {
        const size_t at = (size_t)(w->put_bytes % LOG_BUFFER_BYTES);
        const size_t first =
            size_bytes < LOG_BUFFER_BYTES - at ? size_bytes : LOG_BUFFER_BYTES - at;
        memcpy(w->bytes + at, line, first);
        memcpy(w->bytes, line + first, size_bytes - first);
        w->put_bytes += size_bytes;
        pthread_cond_signal(&w->filled);
    }
    pthread_mutex_unlock(&w->lock);
    return room;
}

uint64_t log_writer_failed(struct log_writer *w)
{
    pthread_mutex_lock(&w->lock);
    const uint64_t failed = w->failed;
    pthread_mutex_unlock(&w->lock);
    return failed;
}

static bool is_done(const struct log_writer *w)
{
    return w->put_bytes == w->taken_bytes && !w->writing;
}

bool log_writer_close(struct log_writer **writer, unsigned most_ms)
{
    struct log_writer *w = *writer;
    struct timespec until;
    *writer = NULL;
    if (!w) return true;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += most_ms / 1000;
    until.tv_nsec += (long)(most_ms % 1000) * 1000000;
    if (until.tv_nsec >= 1000000000) {
        until.tv_sec++;
        until.tv_nsec -= 1000000000;
    }
    pthread_mutex_lock(&w->lock);
    w->ending = true;
    pthread_cond_signal(&w->filled);
    int late = 0;
    while (!is_done(w) && !late) late = pthread_cond_timedwait(&w->emptied, &w->lock, &until);
    const bool done = is_done(w);
    if (!done) pthread_detach(w->thread);
    w->left = !done;
    pthread_mutex_unlock(&w->lock);
    if (!done) return false;
    pthread_join(w->thread, NULL);
    release(w);
    return true;
}
