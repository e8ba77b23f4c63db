#include "server/store/job_webhooks.h"

#include <stdio.h>
#include <stdlib.h>

#include "server/store/job_schema.h"
#include "server/store/job_store_internal.h"

int job_webhooks_add(sqlite3 *db, const char *id, const char *url)
{
    sqlite3_stmt *s = NULL;
    int code =
        sqlite3_prepare_v2(db, "INSERT INTO webhooks (job, url) VALUES (?1, ?2)", -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 2, url, -1, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    sqlite3_finalize(s);
    return job_schema_error(code);
}

int job_webhooks_note(sqlite3 *db, const char *id, uint32_t tries, int64_t due_ms)
{
    const char *change = due_ms < 0 ? "DELETE FROM webhooks WHERE job = ?1"
                                    : "UPDATE webhooks SET tries = ?2, due_ms = ?3 WHERE job = ?1";
    sqlite3_stmt *s = NULL;
    int code = sqlite3_prepare_v2(db, change, -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
    if (code == SQLITE_OK && due_ms >= 0) code = sqlite3_bind_int64(s, 2, tries);
    if (code == SQLITE_OK && due_ms >= 0) code = sqlite3_bind_int64(s, 3, due_ms);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    sqlite3_finalize(s);
    return job_schema_error(code);
}

static void copy_text(sqlite3_stmt *s, int column, char *out, size_t capacity)
{
    const unsigned char *text = sqlite3_column_text(s, column);
    snprintf(out, capacity, "%s", text ? (const char *)text : "");
}

static void read_row(sqlite3_stmt *s, struct webhook_row *row)
{
    copy_text(s, 0, row->id, sizeof row->id);
    copy_text(s, 1, row->url, sizeof row->url);
    copy_text(s, 2, row->state, sizeof row->state);
    copy_text(s, 3, row->name, sizeof row->name);
    row->tries = (uint32_t)sqlite3_column_int64(s, 4);
    row->due_ms = sqlite3_column_int64(s, 5);
}

int job_webhooks_list(sqlite3 *db, struct webhook_row **rows, size_t *count)
{
    sqlite3_stmt *s = NULL;
    *count = 0;
    *rows = calloc(WEBHOOKS_READ, sizeof **rows);
    if (!*rows) return ERR_MEMORY;
    int code = sqlite3_prepare_v2(
        db,
        "SELECT w.job, w.url, j.state, (SELECT name FROM marks WHERE job = w.job), w.tries,"
        " w.due_ms FROM webhooks w JOIN jobs j ON j.id = w.job"
        " WHERE j.state IN ('finished', 'failed', 'cancelled') ORDER BY w.due_ms, w.job LIMIT ?1",
        -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_bind_int(s, 1, WEBHOOKS_READ);
    while (code == SQLITE_OK || code == SQLITE_ROW) {
        code = sqlite3_step(s);
        if (code == SQLITE_ROW) read_row(s, &(*rows)[(*count)++]);
    }
    sqlite3_finalize(s);
    return job_schema_error(code);
}

void job_store_list_webhooks(struct job_store *s, job_store_hooked done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_LIST_WEBHOOKS, NULL, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL, 0);
        return;
    }
    r->call.hooked = done;
    job_batches_submit(&s->batches, r, 0);
}

void job_store_note_webhook(struct job_store *s, const char *id, uint32_t tries, int64_t due_ms,
                            job_store_done done, void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_NOTE_WEBHOOK, id, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY);
        return;
    }
    r->tries = tries;
    r->due_ms = due_ms;
    r->call.done = done;
    job_batches_submit(&s->batches, r, 0);
}
