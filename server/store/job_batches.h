#pragma once
/* Requests to the job store in groups. All changes of a group are one commit, and while one is
 * committed the next one gathers. The store's thread has one group at a time, and alone uses the
 * database then. Functions are for the loop's thread. */
#include "proto/runtime/thread_pool.h"
#include "server/metric/duration_histogram.h"
#include "server/store/job_request.h"

/* Tells that a request was performed; its answer follows. */
typedef void (*job_batches_performed)(void *ctx, const struct job_request *r);

struct job_batches {
    struct pool_task task;    /* the group in work; first, so that a task is its batches */
    struct thread_pool *pool; /* one thread */
    struct job_database *db;
    bool busy;                        /* a group is in work */
    struct job_request *first, *last; /* waiting */
    struct job_request *batch;        /* in work */
    uint64_t commit_us;               /* of that: how long its commit took; 0: it changes nothing */
    bool commit_failed;
    struct duration_histogram commits; /* groups of changes, until they were durable or failed */
    uint64_t failures;                 /* of these */
    uint64_t waiting;                  /* requests now, but for those in work */
    job_batches_performed performed;
    void *ctx;
};

/* Opens the batches. The database is borrowed until job_batches_close. ERR_MEMORY, ERR_IO. */
int job_batches_open(struct job_batches *b, uv_loop_t *loop, struct job_database *db,
                     job_batches_performed performed, void *ctx);

/* Takes the request, and answers it later. With an error (there was no memory for all of it) it
 * answers at once. */
void job_batches_submit(struct job_batches *b, struct job_request *r, int error);

/* Returns whether nothing waits or is in work. The database is then the caller's until the next
 * request. */
bool job_batches_are_done(const struct job_batches *b);

/* Lets waiting requests be performed and answered. The loop must run once more afterwards. */
void job_batches_close(struct job_batches *b);
