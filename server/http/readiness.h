#pragma once
/* Answers /readyz: whether a job can be kept, and whether there is a worker to render it. The disk
 * is tested by a write on a thread of its own, which no upload delays, at most once a second and
 * only on request. A disk that does not answer is reported, too. */
#include <stdbool.h>
#include <uv.h>

struct http;
struct request;

struct readiness {
    uv_thread_t thread; /* while it is busy */
    uv_async_t over;    /* the thread has done it */
    struct http *http;
    struct request *waiting; /* waits for the answer; NULL: none */
    bool open, busy, closing;
    uint64_t asked_ms; /* loop clock at the last test */
    int result, error; /* of the test under way; of the last answer */
};

/* Opens and closes the test. Its handle is one of open_handles, and goes when the disk has
 * answered. */
void readiness_open(struct http *http);
void readiness_close(struct http *http);

/* Answers requests that have waited for too long: the disk does not answer. Called from time to
 * time. */
void readiness_tick(struct http *http);
