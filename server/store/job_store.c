#include "server/store/job_store.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "server/store/job_store_internal.h"

void job_store_look_at_removals(struct job_store *s)
{
    if (s->room.objects) removal_timer_soon(&s->removals);
}

/* What a request was about may be due again. */
static void on_performed(void *ctx, const struct job_request *r)
{
    struct job_store *store = ctx;
    if (r->text) store->searching = false;
    if (job_request_may_wait(r)) job_store_look_at_removals(store);
}

void job_store_totals(const struct job_store *s, struct job_store_totals *out)
{
    const struct job_batches *b = &s->batches;
    *out = (struct job_store_totals){
        .commits = b->commits, .failures = b->failures, .waiting = b->waiting};
}

void job_store_insert(struct job_store *s, const struct job_row *row, const char *idempotency_key,
                      const struct digest *body, job_store_inserted done, void *ctx)
{
    job_store_submit(s, row, idempotency_key, body, NULL, done, ctx);
}

void job_store_submit(struct job_store *s, const struct job_row *row, const char *idempotency_key,
                      const struct digest *body, const struct job_assets *assets,
                      job_store_inserted done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_INSERT, row->id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY, NULL);
        return;
    }
    int error = 0;
    r->document = job_request_copy(row->document, &error);
    r->state = job_request_copy(row->state, &error);
    r->fault = job_request_copy(row->error, &error);
    r->report = job_request_copy(row->report, &error);
    r->name = job_request_copy(row->name, &error);
    r->labels = job_request_copy(row->labels, &error);
    r->webhook = job_request_copy(row->webhook, &error);
    r->key = job_request_copy(idempotency_key, &error);
    r->created_ms = row->created_ms;
    r->updated_ms = row->updated_ms;
    r->priority = row->priority;
    r->paused = row->paused;
    memcpy(r->owner, row->owner, sizeof r->owner);
    memcpy(r->trace, row->trace, sizeof r->trace);
    if (body) r->body = *body;
    if (assets && !error) error = job_store_claim_assets(s, r, row->owner, assets);
    r->call.inserted = done;
    job_batches_submit(&s->batches, r, error);
}

void job_store_find_key(struct job_store *s, const char *owner, const char *idempotency_key,
                        const struct digest *body, job_store_inserted done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_FIND_KEY, "", ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    int error = 0;
    r->key = job_request_copy(idempotency_key, &error);
    memcpy(r->owner, owner, strlen(owner) + 1);
    r->body = *body;
    r->call.inserted = done;
    job_batches_submit(&s->batches, r, error);
}

void job_store_update(struct job_store *s, const char *id, const char *state, const char *fault,
                      const char *report, job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_UPDATE, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    int error = 0;
    r->state = job_request_copy(state, &error);
    r->fault = job_request_copy(fault, &error);
    r->report = job_request_copy(report, &error);
    r->call.done = done;
    job_batches_submit(&s->batches, r, error);
}

void job_store_steer(struct job_store *s, const char *id, const int32_t *priority,
                     const bool *paused, job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_STEER, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    r->has_priority = priority != NULL;
    r->has_paused = paused != NULL;
    if (priority) r->priority = *priority;
    if (paused) r->paused = *paused;
    r->call.done = done;
    job_batches_submit(&s->batches, r, 0);
}

void job_store_mark(struct job_store *s, const char *id, const char *owner, uint64_t seen_revision,
                    const char *marks, job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_MARK, id, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY);
        return;
    }
    int error = 0;
    r->owned = owner != NULL;
    if (owner) snprintf(r->owner, sizeof r->owner, "%s", owner);
    r->seen_revision = seen_revision;
    r->document = job_request_copy(marks, &error);
    r->call.done = done;
    job_batches_submit(&s->batches, r, error);
}

void job_store_update_frame(struct job_store *s, const char *id, const struct frame_row *frame,
                            const char *report, job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_UPDATE_FRAME, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    int error = 0;
    r->frame = *frame;
    r->state = job_request_copy(frame->state, &error);
    r->report = job_request_copy(report, &error);
    r->call.done = done;
    job_batches_submit(&s->batches, r, error);
}

void job_store_update_document(struct job_store *s, const char *id, const char *document,
                               job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_UPDATE_DOCUMENT, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    int error = 0;
    r->document = job_request_copy(document, &error);
    r->call.done = done;
    job_batches_submit(&s->batches, r, error);
}

void job_store_remove(struct job_store *s, const char *id, job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_REMOVE, id, ctx);
    if (!r) {
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    r->call.done = done;
    job_batches_submit(&s->batches, r, 0);
}

void job_store_get(struct job_store *s, const char *id, job_store_found done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_GET, id, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL, NULL, 0);
        return;
    }
    r->call.found = done;
    job_batches_submit(&s->batches, r, 0);
}

void job_store_list(struct job_store *s, const struct job_listing *listing, job_store_listed done,
                    void *ctx)
{
    const bool refused = listing->text && s->searching;
    struct job_request *r = refused ? NULL : job_request_create(REQUEST_LIST, NULL, ctx);
    if (!r) {
        done(ctx, refused ? ERR_STATE : ERR_MEMORY, NULL, 0, false);
        return;
    }
    int error = 0;
    r->state = job_request_copy(listing->state, &error);
    r->cursor = job_request_copy(listing->cursor, &error);
    r->text = job_request_copy(listing->text, &error);
    r->name = job_request_copy(listing->name, &error);
    r->labels = job_request_copy(listing->label, &error);
    r->limit = listing->limit < LIMIT_LIST_ROWS ? listing->limit : LIMIT_LIST_ROWS;
    r->owned = listing->owner != NULL;
    if (r->owned) snprintf(r->owner, sizeof r->owner, "%s", listing->owner);
    r->call.listed = done;
    if (!error && r->text) s->searching = true;
    job_batches_submit(&s->batches, r, error);
}

void job_store_remember_blob(struct job_store *s, const struct digest *source,
                             const struct digest *blob, const struct digest *assets,
                             size_t asset_count, job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_REMEMBER_BLOB, NULL, ctx);
    if (!r) { /* a memory only: without it the import runs again */
        if (done) done(ctx, ERR_MEMORY);
        return;
    }
    r->source = *source;
    r->blob = *blob;
    r->room = s->room;
    r->call.done = done;
    job_batches_submit(&s->batches, r, job_request_take_assets(r, assets, asset_count));
}

void job_store_find_blob(struct job_store *s, const struct digest *source, job_store_blob done,
                         void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_FIND_BLOB, NULL, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL);
        return;
    }
    r->source = *source;
    r->call.blob = done;
    job_batches_submit(&s->batches, r, 0);
}

int job_store_unfinished(struct job_store *s,
                         void (*each)(void *ctx, const struct job_row *row,
                                      const struct frame_row *frames, size_t frame_count),
                         void *ctx)
{
    /* The connection is the caller's only while the store's thread has nothing to do. */
    if (!job_batches_are_done(&s->batches)) return ERR_STATE;
    struct job_records records = {0};
    int error = job_database_unfinished(s->db, &records);
    for (size_t i = 0; !error && i < records.count; i++) {
        const struct job_record *job = &records.items[i];
        each(ctx, &job->row, job->frames, job->frame_count);
    }
    job_records_fini(&records);
    return error;
}

int job_store_newest(struct job_store *s, char id[JOB_ID_BYTES])
{
    if (!job_batches_are_done(&s->batches)) return ERR_STATE;
    struct job_records records = {0};
    const int error = job_database_list(s->db, &(struct job_listing){.limit = 1}, &records);
    id[0] = '\0';
    if (!error && records.count > 0) snprintf(id, JOB_ID_BYTES, "%s", records.items[0].row.id);
    job_records_fini(&records);
    return error;
}

/* Ends a pass of removals. If the disk fails, the round is left and comes again. */
static void on_passed(void *ctx, int error, const struct removal_pass *pass)
{
    static const struct removal_pass left = {.left = 1};
    struct job_store *store = ctx;
    store->pass = error ? left : *pass;
    removal_timer_over(&store->removals, &store->pass);
}

static void on_removals_due(void *ctx)
{
    struct job_store *store = ctx;
    struct job_request *r = job_request_create(REQUEST_PASS_REMOVALS, NULL, store);
    if (!r) {
        on_passed(store, ERR_MEMORY, NULL);
        return;
    }
    r->room = store->room;
    r->pass = store->pass;
    r->call.passed = on_passed;
    job_batches_submit(&store->batches, r, 0);
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

static void close_files(struct job_store *store)
{
    job_database_close(&store->db);
    if (store->lock_fd >= 0) close(store->lock_fd);
}

int job_store_open(uv_loop_t *loop, const char *dir, bool ephemeral, struct job_store **out)
{
    *out = NULL;
    struct job_store *store = calloc(1, sizeof *store);
    if (!store) return ERR_MEMORY;
    store->lock_fd = -1;
    char path[4352];
    int error = lock_dir(dir, &store->lock_fd);
    snprintf(path, sizeof path, "%s/jobs.sqlite", dir);
    if (!error) error = job_database_open(path, ephemeral, &store->db);
    if (!error) error = job_batches_open(&store->batches, loop, store->db, on_performed, store);
    if (error) {
        close_files(store);
        free(store);
        return error;
    }
    removal_timer_init(&store->removals, loop, on_removals_due, store);
    *out = store;
    return 0;
}

static void on_closed(uv_handle_t *handle)
{
    free(handle->data);
}

void job_store_close(struct job_store **out)
{
    struct job_store *store = *out;
    if (!store) return;
    job_batches_close(&store->batches);
    close_files(store);
    store->removals.handle.data = store;
    uv_close((uv_handle_t *)&store->removals.handle, on_closed);
    *out = NULL;
}
