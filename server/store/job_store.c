#include "server/store/job_store.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "server/store/job_database.h"
#include "server/team/team.h"

/* Requests that one commit makes durable together: bounds how long an early one waits. */
#define BATCH_REQUESTS 256

enum request_kind {
    REQUEST_INSERT,
    REQUEST_UPDATE,
    REQUEST_UPDATE_FRAME,
    REQUEST_REMOVE,
    REQUEST_REMEMBER_BLOB,
    REQUEST_GET,
    REQUEST_LIST,
    REQUEST_FIND_BLOB,
};

/* What is asked, and then what came of it. Written by the loop's thread, then by the store's, then
 * read by the loop's: the team's queue hands it over. Texts are owned copies, NULL where absent. */
struct request {
    struct request *next;
    enum request_kind kind;
    int error;
    void *ctx;
    char id[JOB_ID_BYTES];
    char *state, *fault, *report, *document, *key, *cursor;
    int64_t created_ms, updated_ms;
    int32_t priority;
    struct frame_row frame; /* its state is `state` */
    struct digest body, source, blob;
    size_t limit;
    char existing[JOB_ID_BYTES];
    struct job_records records;
    union {
        job_store_inserted inserted;
        job_store_done done;
        job_store_found found;
        job_store_listed listed;
        job_store_blob blob;
    } call;
};

struct job_store {
    struct team_task task; /* the batch in work; first, so that a task is its store */
    struct team *team;     /* one thread */
    struct job_database *db;
    int lock_fd;
    bool busy;
    struct request *first, *last; /* waiting */
    struct request *batch;        /* in work */
};

static bool is_write(enum request_kind kind)
{
    return kind <= REQUEST_REMEMBER_BLOB;
}

static void request_free(struct request *r)
{
    free(r->state);
    free(r->fault);
    free(r->report);
    free(r->document);
    free(r->key);
    free(r->cursor);
    job_records_fini(&r->records);
    free(r);
}

/* -- on the store's thread -- */

static int perform_insert(struct job_database *db, struct request *r)
{
    struct job_row row = {.document = r->document,
                          .state = r->state,
                          .error = r->fault,
                          .report = r->report,
                          .created_ms = r->created_ms,
                          .updated_ms = r->updated_ms,
                          .priority = r->priority};
    memcpy(row.id, r->id, sizeof row.id);
    return job_database_insert(db, &row, r->key, &r->body, r->existing);
}

static int perform_update_frame(struct job_database *db, struct request *r)
{
    struct frame_row frame = r->frame;
    frame.state = r->state;
    return job_database_update_frame(db, r->id, &frame);
}

static int perform(struct job_database *db, struct request *r)
{
    switch (r->kind) {
    case REQUEST_INSERT:
        return perform_insert(db, r);
    case REQUEST_UPDATE:
        return job_database_update(db, r->id, r->state, r->fault, r->report);
    case REQUEST_UPDATE_FRAME:
        return perform_update_frame(db, r);
    case REQUEST_REMOVE:
        return job_database_remove(db, r->id);
    case REQUEST_REMEMBER_BLOB:
        return job_database_remember_blob(db, &r->source, &r->blob);
    case REQUEST_GET:
        return job_database_get(db, r->id, &r->records);
    case REQUEST_LIST:
        return job_database_list(db, r->state, r->cursor, r->limit, &r->records);
    case REQUEST_FIND_BLOB:
        return job_database_find_blob(db, &r->source, &r->blob);
    }
    return ERR_STATE;
}

static void perform_marked(struct job_database *db, struct request *r)
{
    r->error = job_database_mark(db);
    if (r->error) return;
    r->error = perform(db, r);
    job_database_unmark(db, r->error == 0);
}

/* Nothing of the batch is durable: its writes failed, and its reads may have seen them. */
static void fail_batch(struct request *batch, int error)
{
    for (struct request *r = batch; r; r = r->next) {
        if (r->error == 0) r->error = error;
    }
}

/* All requests in order, the changes as one commit. */
static void run_batch(struct team_task *task)
{
    struct job_store *store = (struct job_store *)task;
    bool writes = false;
    for (struct request *r = store->batch; r; r = r->next) writes |= is_write(r->kind);
    int error = writes ? job_database_begin(store->db) : 0;
    if (error) {
        fail_batch(store->batch, error);
        return;
    }
    for (struct request *r = store->batch; r; r = r->next) {
        if (is_write(r->kind))
            perform_marked(store->db, r);
        else
            r->error = perform(store->db, r);
        /* A full disk ends the whole batch by itself; what follows would commit on its own. */
        if (writes && !job_database_in_batch(store->db)) break;
    }
    if (!writes) return;
    error = job_database_in_batch(store->db) ? job_database_commit(store->db) : ERR_IO;
    if (!error) return;
    job_database_rollback(store->db);
    fail_batch(store->batch, error);
}

/* -- on the loop's thread -- */

static void answer_found(const struct request *r)
{
    const struct job_record *job = r->records.count ? r->records.items : NULL;
    if (r->error || !job)
        r->call.found(r->ctx, r->error, NULL, NULL, 0);
    else
        r->call.found(r->ctx, 0, &job->row, job->frames, job->frame_count);
}

static void answer_listed(const struct request *r)
{
    size_t count = r->records.count < r->limit ? r->records.count : r->limit;
    struct job_row *rows = calloc(count ? count : 1, sizeof *rows);
    int error = rows ? r->error : ERR_MEMORY;
    if (error) count = 0;
    for (size_t i = 0; i < count; i++) rows[i] = r->records.items[i].row;
    r->call.listed(r->ctx, error, rows, count, !error && r->records.more);
    free(rows);
}

static void answer_blob(const struct request *r)
{
    bool unknown = r->error == ERR_NOT_FOUND;
    r->call.blob(r->ctx, unknown ? 0 : r->error, r->error ? NULL : &r->blob);
}

static void answer(const struct request *r)
{
    switch (r->kind) {
    case REQUEST_INSERT:
        if (r->call.inserted)
            r->call.inserted(r->ctx, r->error, r->error == ERR_EXISTS ? r->existing : NULL);
        break;
    case REQUEST_UPDATE:
    case REQUEST_UPDATE_FRAME:
    case REQUEST_REMOVE:
    case REQUEST_REMEMBER_BLOB:
        if (r->call.done) r->call.done(r->ctx, r->error);
        break;
    case REQUEST_GET:
        answer_found(r);
        break;
    case REQUEST_LIST:
        answer_listed(r);
        break;
    case REQUEST_FIND_BLOB:
        answer_blob(r);
        break;
    }
}

/* Takes the oldest requests, at most a batch of them, off the queue. */
static struct request *take_batch(struct job_store *store)
{
    struct request *batch = store->first, *end = batch;
    for (int i = 1; end && end->next && i < BATCH_REQUESTS; i++) end = end->next;
    if (!end) return NULL;
    store->first = end->next;
    if (!store->first) store->last = NULL;
    end->next = NULL;
    return batch;
}

/* While a batch is being committed the next one gathers: that is what makes a commit a group's. */
static void start_batch(struct job_store *store)
{
    if (store->busy || !store->first) return;
    store->batch = take_batch(store);
    store->busy = true;
    team_submit(store->team, &store->task);
}

static void batch_done(struct team_task *task)
{
    struct job_store *store = (struct job_store *)task;
    struct request *batch = store->batch;
    store->batch = NULL;
    store->busy = false;
    start_batch(store); /* first, so that the disk works while the answers go out */
    while (batch) {
        struct request *r = batch;
        batch = r->next;
        answer(r);
        request_free(r);
    }
}

static void enqueue(struct job_store *store, struct request *r)
{
    if (store->last)
        store->last->next = r;
    else
        store->first = r;
    store->last = r;
    start_batch(store);
}

/* Copies text; notes a failed copy in *error. */
static char *copy(const char *text, int *error)
{
    char *out = text ? strdup(text) : NULL;
    if (text && !out) *error = ERR_MEMORY;
    return out;
}

static struct request *request_create(enum request_kind kind, const char *id, void *ctx)
{
    struct request *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    r->kind = kind;
    r->ctx = ctx;
    /* One that is too long names no job: it must not be cut to one that does. */
    if (id && strlen(id) < sizeof r->id) strcpy(r->id, id);
    return r;
}

/* Without memory for the request itself the answer comes at once. */
static void submit(struct job_store *store, struct request *r, int error)
{
    if (!error) {
        enqueue(store, r);
        return;
    }
    r->error = error;
    answer(r);
    request_free(r);
}

void job_store_insert(struct job_store *s, const struct job_row *row, const char *idempotency_key,
                      const struct digest *body, job_store_inserted done, void *ctx)
{
    struct request *r = request_create(REQUEST_INSERT, row->id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY, NULL);
        return;
    }
    int error = 0;
    r->document = copy(row->document, &error);
    r->state = copy(row->state, &error);
    r->fault = copy(row->error, &error);
    r->report = copy(row->report, &error);
    r->key = copy(idempotency_key, &error);
    r->created_ms = row->created_ms;
    r->updated_ms = row->updated_ms;
    r->priority = row->priority;
    if (body) r->body = *body;
    r->call.inserted = done;
    submit(s, r, error);
}

void job_store_update(struct job_store *s, const char *id, const char *state, const char *fault,
                      const char *report, job_store_done done, void *ctx)
{
    struct request *r = request_create(REQUEST_UPDATE, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    int error = 0;
    r->state = copy(state, &error);
    r->fault = copy(fault, &error);
    r->report = copy(report, &error);
    r->call.done = done;
    submit(s, r, error);
}

void job_store_update_frame(struct job_store *s, const char *id, const struct frame_row *frame,
                            job_store_done done, void *ctx)
{
    struct request *r = request_create(REQUEST_UPDATE_FRAME, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    int error = 0;
    r->frame = *frame;
    r->state = copy(frame->state, &error);
    r->call.done = done;
    submit(s, r, error);
}

void job_store_remove(struct job_store *s, const char *id, job_store_done done, void *ctx)
{
    struct request *r = request_create(REQUEST_REMOVE, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    r->call.done = done;
    submit(s, r, 0);
}

void job_store_get(struct job_store *s, const char *id, job_store_found done, void *ctx)
{
    struct request *r = request_create(REQUEST_GET, id, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL, NULL, 0);
        return;
    }
    r->call.found = done;
    submit(s, r, 0);
}

void job_store_list(struct job_store *s, const char *state, const char *cursor, size_t limit,
                    job_store_listed done, void *ctx)
{
    struct request *r = request_create(REQUEST_LIST, NULL, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL, 0, false);
        return;
    }
    int error = 0;
    r->state = copy(state, &error);
    r->cursor = copy(cursor, &error);
    r->limit = limit < LIMIT_LIST_ROWS ? limit : LIMIT_LIST_ROWS;
    r->call.listed = done;
    submit(s, r, error);
}

void job_store_remember_blob(struct job_store *s, const struct digest *source,
                             const struct digest *blob)
{
    struct request *r = request_create(REQUEST_REMEMBER_BLOB, NULL, NULL);
    if (!r) return; /* a memory only: without it the import runs again */
    r->source = *source;
    r->blob = *blob;
    submit(s, r, 0);
}

void job_store_find_blob(struct job_store *s, const struct digest *source, job_store_blob done,
                         void *ctx)
{
    struct request *r = request_create(REQUEST_FIND_BLOB, NULL, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    r->source = *source;
    r->call.blob = done;
    submit(s, r, 0);
}

int job_store_unfinished(struct job_store *s,
                         void (*each)(void *ctx, const struct job_row *row,
                                      const struct frame_row *frames, size_t frame_count),
                         void *ctx)
{
    /* The connection is the caller's only while the store's thread has nothing to do. */
    if (s->busy || s->first) return ERR_STATE;
    struct job_records records = {0};
    int error = job_database_unfinished(s->db, &records);
    for (size_t i = 0; !error && i < records.count; i++) {
        const struct job_record *job = &records.items[i];
        each(ctx, &job->row, job->frames, job->frame_count);
    }
    job_records_fini(&records);
    return error;
}

/* Two coordinators on one folder would undo each other's work. */
static int lock_dir(const char *dir, int *fd)
{
    char path[4352];
    if (snprintf(path, sizeof path, "%s/jobs.lock", dir) >= (int)sizeof path) return ERR_LIMIT;
    *fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (*fd < 0) return ERR_IO;
    if (!flock(*fd, LOCK_EX | LOCK_NB)) return 0;
    int error = errno == EWOULDBLOCK ? ERR_STATE : ERR_IO;
    close(*fd);
    *fd = -1;
    return error;
}

int job_store_open(uv_loop_t *loop, const char *dir, struct job_store **out)
{
    *out = NULL;
    struct job_store *store = calloc(1, sizeof *store);
    if (!store) return ERR_MEMORY;
    store->lock_fd = -1;
    store->task.run = run_batch;
    store->task.done = batch_done;
    char path[4352];
    int error = lock_dir(dir, &store->lock_fd);
    snprintf(path, sizeof path, "%s/jobs.sqlite", dir);
    if (!error) error = job_database_open(path, &store->db);
    if (!error) error = team_create(loop, "store", 1, &store->team);
    if (error) {
        job_store_close(&store);
        return error;
    }
    *out = store;
    return 0;
}

void job_store_close(struct job_store **out)
{
    struct job_store *store = *out;
    if (!store) return;
    team_destroy(&store->team);
    job_database_close(&store->db);
    if (store->lock_fd >= 0) close(store->lock_fd);
    free(store);
    *out = NULL;
}
