#include "server/store/job_request.h"

#include <stdlib.h>
#include <string.h>

#include "server/store/asset_tables.h"
#include "server/store/job_mark_rows.h"
#include "server/store/job_thumbnails.h"
#include "server/store/job_webhooks.h"

struct job_request *job_request_create(enum request_kind kind, const char *id, void *ctx)
{
    struct job_request *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    r->kind = kind;
    r->ctx = ctx;
    /* One that is too long names no job: it must not be cut to one that does. */
    if (id && strlen(id) < sizeof r->id) memcpy(r->id, id, strlen(id) + 1);
    return r;
}

void job_request_free(struct job_request *r)
{
    free(r->state);
    free(r->fault);
    free(r->report);
    free(r->document);
    free(r->key);
    free(r->cursor);
    free(r->text);
    free(r->name);
    free(r->labels);
    free(r->assets);
    free(r->png);
    free(r->webhook);
    free(r->webhooks);
    job_records_fini(&r->records);
    free(r);
}

char *job_request_copy(const char *text, int *error)
{
    char *out = text ? strdup(text) : NULL;
    if (text && !out) *error = ERR_MEMORY;
    return out;
}

int job_request_take_assets(struct job_request *r, const struct digest *assets, size_t count)
{
    r->assets = malloc((count ? count : 1) * sizeof *r->assets);
    if (!r->assets) return ERR_MEMORY;
    if (count) memcpy(r->assets, assets, count * sizeof *assets);
    r->asset_count = count;
    return 0;
}

static void take_text(char **text, char **newer)
{
    if (!*newer) return;
    free(*text);
    *text = *newer;
    *newer = NULL;
}

void job_request_take_texts(struct job_request *r, struct job_request *newer)
{
    take_text(&r->state, &newer->state);
    take_text(&r->fault, &newer->fault);
    take_text(&r->report, &newer->report);
    take_text(&r->document, &newer->document);
}

bool job_request_is_write(const struct job_request *r)
{
    return r->kind <= REQUEST_REMEMBER_BLOB;
}

bool job_request_is_lone_write(const struct job_request *r)
{
    return r->kind == REQUEST_REMOVE_ASSET || r->kind == REQUEST_PASS_REMOVALS;
}

bool job_request_may_wait(const struct job_request *r)
{
    return r->kind == REQUEST_REMOVE_ASSET || r->kind == REQUEST_NOTE_REMOVAL || r->gone;
}

/* Those of a row that is being inserted cannot go from now on. */
static int find_assets(struct job_request *r, sqlite3 *db)
{
    int error = 0;
    for (r->missing = 0; r->missing < r->asset_count; r->missing++) {
        r->claim.asset = r->assets[r->missing];
        if ((error = asset_room_find(db, &r->room, &r->claim)) != 0) break;
    }
    return error;
}

static int perform_insert(struct job_database *db, struct job_request *r)
{
    struct job_row row = {.document = r->document,
                          .state = r->state,
                          .error = r->fault,
                          .report = r->report,
                          .created_ms = r->created_ms,
                          .updated_ms = r->updated_ms,
                          .priority = r->priority,
                          .paused = r->paused,
                          .name = r->name,
                          .labels = r->labels,
                          .webhook = r->webhook};
    memcpy(row.id, r->id, sizeof row.id);
    memcpy(row.owner, r->owner, sizeof row.owner);
    memcpy(row.trace, r->trace, sizeof row.trace);
    const int error = job_database_insert(db, &row, r->key, &r->body, r->existing);
    if (error || !r->asset_count) return error;
    return find_assets(r, job_database_connection(db)); /* the row is undone then */
}

static int perform_remember_blob(struct job_database *db, struct job_request *r)
{
    const int error =
        !r->room.objects
            ? 0
            : asset_removal_check_import(job_database_connection(db), &r->room, r->assets,
                                         r->asset_count, &r->blob, &r->gone);
    if (error || r->gone) return error;
    return job_database_remember_blob(db, &r->source, &r->blob, r->assets, r->asset_count);
}

static int perform_update_frame(struct job_database *db, struct job_request *r)
{
    struct frame_row frame = r->frame;
    frame.state = r->state;
    const int error = job_database_update_frame(db, r->id, &frame);
    return error || !r->report ? error : job_database_update(db, r->id, NULL, NULL, r->report);
}

static int perform_of_assets(struct job_request *r, sqlite3 *db)
{
    switch (r->kind) {
    case REQUEST_KEEP_ASSET:
        return asset_room_keep(db, &r->room, &r->claim, r->size_bytes, &r->existed);
    case REQUEST_NOTE_REMOVAL:
        return asset_removals_add(db, &r->claim.asset);
    case REQUEST_FIND_ASSETS:
        return find_assets(r, db);
    case REQUEST_REMOVE_ASSET:
        return asset_removal_run(db, &r->room, &r->claim, &r->users);
    default:
        asset_removal_pass(db, &r->room, &r->pass);
        return 0;
    }
}

static int perform(struct job_request *r, struct job_database *db)
{
    switch (r->kind) {
    case REQUEST_INSERT:
        return perform_insert(db, r);
    case REQUEST_FIND_KEY:
        return job_database_find_key(db, r->owner, r->key, &r->body, r->existing);
    case REQUEST_UPDATE:
        return job_database_update(db, r->id, r->state, r->fault, r->report);
    case REQUEST_STEER:
        return job_database_steer(db, r->id, r->has_priority ? &r->priority : NULL,
                                  r->has_paused ? &r->paused : NULL);
    case REQUEST_MARK:
        return job_mark_rows_change(job_database_connection(db), r->id, r->owned ? r->owner : NULL,
                                    r->seen_revision, r->document);
    case REQUEST_UPDATE_FRAME:
        return perform_update_frame(db, r);
    case REQUEST_UPDATE_DOCUMENT:
        return job_database_update_document(db, r->id, r->document);
    case REQUEST_REMOVE:
        return job_database_remove(db, r->id);
    case REQUEST_REMEMBER_BLOB:
        return perform_remember_blob(db, r);
    case REQUEST_KEEP_THUMBNAIL:
        return job_thumbnails_keep(job_database_connection(db), r->id, r->png, r->png_bytes);
    case REQUEST_FIND_THUMBNAIL:
        return job_thumbnails_find(job_database_connection(db), r->id, &r->png, &r->png_bytes);
    case REQUEST_NOTE_WEBHOOK:
        return job_webhooks_note(job_database_connection(db), r->id, r->tries, r->due_ms);
    case REQUEST_LIST_WEBHOOKS:
        return job_webhooks_list(job_database_connection(db), &r->webhooks, &r->webhook_count);
    case REQUEST_GET:
        return job_database_get(db, r->id, &r->records);
    case REQUEST_LIST:
        return job_database_list(db,
                                 &(struct job_listing){.state = r->state,
                                                       .cursor = r->cursor,
                                                       .text = r->text,
                                                       .name = r->name,
                                                       .label = r->labels,
                                                       .owner = r->owned ? r->owner : NULL,
                                                       .limit = r->limit},
                                 &r->records);
    case REQUEST_FIND_BLOB:
        return job_database_find_blob(db, &r->source, &r->blob);
    case REQUEST_KEEP_ASSET:
    case REQUEST_NOTE_REMOVAL:
    case REQUEST_FIND_ASSETS:
    case REQUEST_REMOVE_ASSET:
    case REQUEST_PASS_REMOVALS:
        return perform_of_assets(r, job_database_connection(db));
    }
    return ERR_STATE;
}

int job_request_perform(struct job_request *r, struct job_database *db)
{
    const int error = perform(r, db);
    job_database_note(db, error);
    return error;
}

static void answer_found(const struct job_request *r)
{
    const struct job_record *job = r->records.count ? r->records.items : NULL;
    if (r->error || !job)
        r->call.found(r->ctx, r->error, NULL, NULL, 0);
    else
        r->call.found(r->ctx, 0, &job->row, job->frames, job->frame_count);
}

static void answer_listed(const struct job_request *r)
{
    size_t count = r->records.count < r->limit ? r->records.count : r->limit;
    struct job_row *rows = calloc(count ? count : 1, sizeof *rows);
    int error = rows ? r->error : ERR_MEMORY;
    if (error) count = 0;
    for (size_t i = 0; i < count; i++) rows[i] = r->records.items[i].row;
    r->call.listed(r->ctx, error, rows, count, !error && r->records.more);
    free(rows);
}

static void answer_blob(const struct job_request *r)
{
    bool unknown = r->error == ERR_NOT_FOUND;
    r->call.blob(r->ctx, unknown ? 0 : r->error, r->error ? NULL : &r->blob);
}

void job_request_answer(const struct job_request *r)
{
    if (r->tell_missing) *r->tell_missing = r->missing;
    switch (r->kind) {
    case REQUEST_INSERT:
    case REQUEST_FIND_KEY:
        if (r->call.inserted)
            r->call.inserted(r->ctx, r->error, r->error == ERR_EXISTS ? r->existing : NULL);
        break;
    case REQUEST_UPDATE:
    case REQUEST_STEER:
    case REQUEST_MARK:
    case REQUEST_UPDATE_FRAME:
    case REQUEST_UPDATE_DOCUMENT:
    case REQUEST_REMOVE:
    case REQUEST_NOTE_REMOVAL:
    case REQUEST_KEEP_THUMBNAIL:
    case REQUEST_NOTE_WEBHOOK:
    case REQUEST_FIND_ASSETS:
        if (r->call.done) r->call.done(r->ctx, r->error);
        break;
    case REQUEST_REMEMBER_BLOB:
        if (r->call.done) r->call.done(r->ctx, r->error || !r->gone ? r->error : ERR_NOT_FOUND);
        break;
    case REQUEST_KEEP_ASSET:
        r->call.kept(r->ctx, r->error, r->existed);
        break;
    case REQUEST_GET:
        answer_found(r);
        break;
    case REQUEST_LIST_WEBHOOKS:
        r->call.hooked(r->ctx, r->error, r->webhooks, r->error ? 0 : r->webhook_count);
        break;
    case REQUEST_FIND_THUMBNAIL:
        r->call.pictured(r->ctx, r->error, r->png, r->png_bytes);
        break;
    case REQUEST_LIST:
        answer_listed(r);
        break;
    case REQUEST_FIND_BLOB:
        answer_blob(r);
        break;
    case REQUEST_REMOVE_ASSET:
        r->call.gave_up(r->ctx, r->error, &r->users);
        break;
    case REQUEST_PASS_REMOVALS:
        r->call.passed(r->ctx, r->error, &r->pass);
        break;
    }
}
