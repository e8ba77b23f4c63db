#pragma once
/* /readyz: can a job be kept, and is there a worker to render it? The disk is asked, by a write, on
 * a thread of its own, which waits for no upload's: at most once a second, and only when somebody
 * wants to know. A disk that does not answer is told of, too. */
#include <stdbool.h>
#include <uv.h>

struct http;
struct request;

struct readiness {
    uv_thread_t thread; /* while it is busy */
    uv_async_t over;    /* the thread has done it */
    struct http *http;
    struct request *waiting; /* for the answer; NULL: nobody */
    bool open, busy, closing;
    uint64_t asked_ms; /* of the loop's clock: when last */
    int result, error; /* of the work in hand; of what was answered last */
};

/* At the start and the end. The handle is one of open_handles; it goes when the disk has answered.
 */
void readiness_open(struct http *http);
void readiness_close(struct http *http);

/* From time to time: who has waited for too long learns that the disk does not answer. */
void readiness_tick(struct http *http);
