#include "server/store/job_batches.h"

#include <string.h>

#include "server/store/job_database.h"

/* Requests that one commit makes durable together: bounds how long an early one waits. */
#define BATCH_REQUESTS 256

/* -- on the store's thread -- */

static void perform_marked(struct job_database *db, struct job_request *r)
{
    r->error = job_database_mark(db);
    if (r->error) return;
    r->error = job_request_perform(r, db);
    job_database_unmark(db, r->error == 0);
}

static void perform_changes(struct job_batches *b)
{
    for (struct job_request *r = b->batch; r; r = r->next) {
        if (!job_request_is_write(r)) continue;
        perform_marked(b->db, r);
        /* A full disk ends the whole batch by itself; what follows would commit on its own. */
        if (!job_database_in_batch(b->db)) return;
    }
}

/* As one commit: 0 when all of it is durable, else nothing is. */
static int commit_changes(struct job_batches *b)
{
    int error = job_database_begin(b->db);
    if (error) return error;
    perform_changes(b);
    error = job_database_in_batch(b->db) ? job_database_commit(b->db) : ERR_IO;
    if (error) job_database_rollback(b->db);
    return error;
}

static void fail_changes(struct job_request *batch, int error)
{
    for (struct job_request *r = batch; r; r = r->next)
        if (job_request_is_write(r) && r->error == 0) r->error = error;
}

/* Performs a batch. Queries come after the changes, so they see what is durable, and are answered
 * even if the disk is full. Returns 0 when the changes are durable. */
static int perform_batch(struct job_batches *b, bool writes, bool lone_writes)
{
    int error = job_database_refresh(b->db, writes || lone_writes);
    const bool is_open = job_database_is_open(b->db);
    if (!error && writes) error = commit_changes(b);
    if (error) fail_changes(b->batch, error);
    for (struct job_request *r = b->batch; r; r = r->next)
        if (!job_request_is_write(r)) r->error = is_open ? job_request_perform(r, b->db) : error;
    return error;
}

static void run_batch(struct pool_task *task)
{
    struct job_batches *b = (struct job_batches *)task;
    const uint64_t began_ns = uv_hrtime();
    bool writes = false, lone_writes = false;
    for (struct job_request *r = b->batch; r; r = r->next) {
        writes |= job_request_is_write(r);
        lone_writes |= job_request_is_lone_write(r);
    }
    b->commit_failed = perform_batch(b, writes, lone_writes) != 0;
    b->commit_us = writes ? (uv_hrtime() - began_ns) / 1000 + 1 : 0;
}

/* -- on the loop's thread -- */

static void count_commit(struct job_batches *b)
{
    if (b->commit_us) duration_histogram_add(&b->commits, b->commit_us);
    b->failures += b->commit_failed;
}

/* Takes the oldest requests, at most a batch of them, off the queue. */
static struct job_request *take_batch(struct job_batches *b)
{
    struct job_request *batch = b->first, *end = batch;
    int count = 1;
    for (; end && end->next && count < BATCH_REQUESTS; count++) end = end->next;
    if (!end) return NULL;
    b->waiting -= (uint64_t)count;
    b->first = end->next;
    if (!b->first) b->last = NULL;
    end->next = NULL;
    return batch;
}

/* While a batch is being committed the next one gathers: that is what makes a commit a group's. */
static void start_batch(struct job_batches *b)
{
    if (b->busy || !b->first) return;
    b->batch = take_batch(b);
    b->busy = true;
    thread_pool_submit(b->pool, &b->task);
}

static void batch_done(struct pool_task *task)
{
    struct job_batches *b = (struct job_batches *)task;
    struct job_request *batch = b->batch;
    b->batch = NULL;
    b->busy = false;
    count_commit(b);
    start_batch(b); /* first, so that the disk works while the answers go out */
    while (batch) {
        struct job_request *r = batch;
        batch = r->next;
        b->performed(b->ctx, r);
        job_request_answer(r);
        job_request_free(r);
    }
}

/* Replaces an older report that still waits, so that on a disk that hangs for hours each job has
 * one, and one for each of its frames. A report has no callback, and requests in between do not
 * concern its text. Only a frame's report would, and then the older one stays. */
static bool join_waiting(struct job_batches *b, struct job_request *r)
{
    struct job_request *last = NULL;
    if ((r->kind != REQUEST_UPDATE && r->kind != REQUEST_UPDATE_DOCUMENT) || r->call.done)
        return false;
    for (struct job_request *w = b->first; w; w = w->next) {
        if (strcmp(w->id, r->id) != 0) continue;
        if (w->kind == r->kind) last = w;
        if (w->kind == REQUEST_UPDATE_FRAME && w->report && r->report) last = NULL;
    }
    if (!last) return false;
    job_request_take_texts(last, r);
    job_request_free(r);
    return true;
}

static void enqueue(struct job_batches *b, struct job_request *r)
{
    if (join_waiting(b, r)) return;
    if (b->last)
        b->last->next = r;
    else
        b->first = r;
    b->last = r;
    b->waiting++;
    start_batch(b);
}

void job_batches_submit(struct job_batches *b, struct job_request *r, int error)
{
    if (!error) {
        enqueue(b, r);
        return;
    }
    r->error = error;
    job_request_answer(r);
    job_request_free(r);
}

int job_batches_open(struct job_batches *b, uv_loop_t *loop, struct job_database *db,
                     job_batches_performed performed, void *ctx)
{
    *b = (struct job_batches){.task = {.run = run_batch, .done = batch_done},
                              .db = db,
                              .performed = performed,
                              .ctx = ctx};
    return thread_pool_create(loop, "store", 1, NULL, &b->pool);
}

bool job_batches_are_done(const struct job_batches *b)
{
    return !b->busy && !b->first;
}

void job_batches_close(struct job_batches *b)
{
    thread_pool_destroy(&b->pool);
}
