#include "server/store/job_database.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/clock.h"
#include "server/store/asset_tables.h"
#include "server/store/job_mark_rows.h"
#include "server/store/job_queries.h"
#include "server/store/job_schema.h"
#include "server/store/job_webhooks.h"

struct job_database {
    char *path;                            /* owned */
    sqlite3 *db;                           /* NULL: it could not be opened again */
    sqlite3_stmt *statements[QUERY_COUNT]; /* prepared when first needed */
    bool ephemeral;
    bool suspect; /* a file of it failed: this connection may never write again */
};

int job_database_open(const char *path, bool ephemeral, struct job_database **out)
{
    *out = NULL;
    struct job_database *db = calloc(1, sizeof *db);
    if (!db) return ERR_MEMORY;
    db->path = strdup(path);
    db->ephemeral = ephemeral;
    int error = db->path ? job_schema_open(path, ephemeral, &db->db) : ERR_MEMORY;
    if (error)
        job_database_close(&db);
    else
        *out = db;
    return error;
}

static void close_connection(struct job_database *db)
{
    for (int i = 0; i < QUERY_COUNT; i++) sqlite3_finalize(db->statements[i]);
    memset(db->statements, 0, sizeof db->statements);
    sqlite3_close(db->db);
    db->db = NULL;
}

void job_database_close(struct job_database **out)
{
    struct job_database *db = *out;
    if (!db) return;
    close_connection(db);
    free(db->path);
    free(db);
    *out = NULL;
}

/* The connection of before is closed first: what one has open in a process all others share. One
 * that only reads stays as it is: on a disk that fails there might be none after it. */
int job_database_refresh(struct job_database *db, bool to_write)
{
    if (db->db && !(db->suspect && to_write)) return 0;
    int error = job_schema_probe(db->path);
    if (error) return error;
    close_connection(db);
    error = job_schema_open(db->path, db->ephemeral, &db->db);
    db->suspect = error != 0;
    return error;
}

bool job_database_is_open(const struct job_database *db)
{
    return db->db != NULL;
}

sqlite3 *job_database_connection(struct job_database *db)
{
    return db->db;
}

void job_database_note(struct job_database *db, int error)
{
    if (error == ERR_IO) db->suspect = true;
}

static int error_of(struct job_database *db, int code)
{
    const int error = job_schema_error(code);
    job_database_note(db, error);
    return error;
}

/* The statement, ready to bind; NULL when it cannot be prepared. */
static sqlite3_stmt *statement(struct job_database *db, enum query query)
{
    sqlite3_stmt **s = &db->statements[query];
    if (!*s) {
        sqlite3_prepare_v3(db->db, job_query_text(query), -1, SQLITE_PREPARE_PERSISTENT, s, NULL);
        if (!*s) return NULL;
    }
    sqlite3_reset(*s);
    sqlite3_clear_bindings(*s);
    return *s;
}

/* Text and digests are borrowed until the statement is done: every query is stepped to its end
 * before its caller returns. */
static void bind_text(sqlite3_stmt *s, int at, const char *text)
{
    if (text) sqlite3_bind_text(s, at, text, -1, SQLITE_STATIC);
}

static void bind_digest(sqlite3_stmt *s, int at, const struct digest *d)
{
    if (d && !digest_is_zero(d)) sqlite3_bind_blob(s, at, d->bytes, DIGEST_BYTES, SQLITE_STATIC);
}

static int finish(struct job_database *db, sqlite3_stmt *s)
{
    if (!s) return error_of(db, sqlite3_errcode(db->db));
    int code = sqlite3_step(s);
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    return error_of(db, code);
}

static int run(struct job_database *db, enum query query)
{
    return finish(db, statement(db, query));
}

/* Does as finish, for a change that must meet a row. */
static int finish_one(struct job_database *db, sqlite3_stmt *s)
{
    int error = finish(db, s);
    if (error) return error;
    return sqlite3_changes(db->db) ? 0 : ERR_NOT_FOUND;
}

int job_database_begin(struct job_database *db)
{
    return run(db, QUERY_BEGIN);
}

int job_database_commit(struct job_database *db)
{
    return run(db, QUERY_COMMIT);
}

void job_database_rollback(struct job_database *db)
{
    run(db, QUERY_ROLLBACK); /* fails where SQLite has rolled back by itself */
}

bool job_database_in_batch(const struct job_database *db)
{
    return !sqlite3_get_autocommit(db->db);
}

int job_database_mark(struct job_database *db)
{
    return run(db, QUERY_MARK);
}

void job_database_unmark(struct job_database *db, bool keep)
{
    if (!keep) run(db, QUERY_UNDO);
    run(db, QUERY_KEEP);
}

static int64_t now_ms(void)
{
    return (int64_t)(clock_us(CLOCK_REALTIME) / 1000);
}

/* Keys of different owners are different keys. No key has a blank in it, and no owner's name. */
typedef char scoped_key[JOB_OWNER_BYTES + LIMIT_IDEMPOTENCY_KEY_BYTES + 2];

static const char *scope_key(const char *owner, const char *key, scoped_key out)
{
    if (!key || !owner[0]) return key;
    snprintf(out, sizeof(scoped_key), "%s %s", owner, key);
    return out;
}

/* 0 when the key is new. */
static int check_key(struct job_database *db, const char *key, const struct digest *body,
                     char existing[JOB_ID_BYTES])
{
    sqlite3_stmt *s = statement(db, QUERY_FIND_KEY);
    if (!s) return finish(db, s);
    bind_text(s, 1, key);
    int code = sqlite3_step(s), error = error_of(db, code);
    if (code == SQLITE_ROW) {
        struct digest known;
        bool same = job_record_digest(s, 0, &known) && digest_equal(&known, body);
        if (same) job_record_id(s, 1, existing);
        error = same ? ERR_EXISTS : ERR_MISMATCH;
    }
    sqlite3_reset(s);
    return error;
}

static int insert_row(struct job_database *db, const struct job_row *row)
{
    sqlite3_stmt *s = statement(db, QUERY_INSERT);
    if (!s) return finish(db, s);
    bind_text(s, 1, row->id);
    bind_text(s, 2, row->document);
    bind_text(s, 3, row->state);
    bind_text(s, 4, row->error);
    bind_text(s, 5, row->report);
    sqlite3_bind_int64(s, 6, row->created_ms);
    sqlite3_bind_int64(s, 7, row->updated_ms);
    sqlite3_bind_int(s, 8, row->priority);
    sqlite3_bind_int(s, 9, row->paused);
    bind_text(s, 10, row->owner);
    bind_text(s, 11, row->trace);
    return finish(db, s);
}

static int insert_key(struct job_database *db, const char *key, const struct digest *body,
                      const char *id)
{
    sqlite3_stmt *s = statement(db, QUERY_INSERT_KEY);
    if (!s) return finish(db, s);
    bind_text(s, 1, key);
    sqlite3_bind_blob(s, 2, body->bytes, DIGEST_BYTES, SQLITE_STATIC);
    bind_text(s, 3, id);
    return finish(db, s);
}

int job_database_find_key(struct job_database *db, const char *owner, const char *key,
                          const struct digest *body, char existing[JOB_ID_BYTES])
{
    scoped_key scoped;
    existing[0] = 0;
    return check_key(db, scope_key(owner, key, scoped), body, existing);
}

int job_database_insert(struct job_database *db, const struct job_row *row, const char *key,
                        const struct digest *body, char existing[JOB_ID_BYTES])
{
    scoped_key scoped;
    existing[0] = 0;
    key = scope_key(row->owner, key, scoped);
    int error = key ? check_key(db, key, body, existing) : 0;
    if (error) return error;
    error = insert_row(db, row);
    /* ERR_EXISTS is for keys; an id that was given twice is the caller's mistake. */
    if (error == ERR_EXISTS) return ERR_STATE;
    if (!error) error = job_mark_rows_add(db->db, row);
    if (!error && row->webhook) error = job_webhooks_add(db->db, row->id, row->webhook);
    if (!error && key) error = insert_key(db, key, body, row->id);
    return error;
}

int job_database_update(struct job_database *db, const char *id, const char *state,
                        const char *error, const char *report)
{
    sqlite3_stmt *s = statement(db, QUERY_UPDATE);
    if (!s) return finish(db, s);
    bind_text(s, 1, id);
    bind_text(s, 2, state);
    bind_text(s, 3, error);
    bind_text(s, 4, report);
    sqlite3_bind_int64(s, 5, now_ms());
    return finish_one(db, s);
}

int job_database_steer(struct job_database *db, const char *id, const int32_t *priority,
                       const bool *paused)
{
    sqlite3_stmt *s = statement(db, QUERY_STEER);
    if (!s) return finish(db, s);
    bind_text(s, 1, id);
    if (priority) sqlite3_bind_int(s, 2, *priority);
    if (paused) sqlite3_bind_int(s, 3, *paused);
    sqlite3_bind_int64(s, 4, now_ms());
    return finish_one(db, s);
}

int job_database_update_frame(struct job_database *db, const char *id,
                              const struct frame_row *frame)
{
    sqlite3_stmt *s = statement(db, QUERY_UPDATE_FRAME);
    if (!s) return finish(db, s);
    bind_text(s, 1, id);
    sqlite3_bind_int(s, 2, frame->number);
    bind_text(s, 3, frame->state);
    bind_digest(s, 4, &frame->exr);
    bind_digest(s, 5, &frame->png);
    return finish_one(db, s);
}

int job_database_update_document(struct job_database *db, const char *id, const char *document)
{
    sqlite3_stmt *s = statement(db, QUERY_UPDATE_DOCUMENT);
    if (!s) return finish(db, s);
    bind_text(s, 1, id);
    bind_text(s, 2, document);
    sqlite3_bind_int64(s, 3, now_ms());
    return finish_one(db, s);
}

int job_database_remove(struct job_database *db, const char *id)
{
    sqlite3_stmt *s = statement(db, QUERY_REMOVE);
    if (s) bind_text(s, 1, id);
    return s ? finish_one(db, s) : finish(db, s);
}

int job_database_remember_blob(struct job_database *db, const struct digest *source,
                               const struct digest *blob, const struct digest *assets,
                               size_t asset_count)
{
    sqlite3_stmt *s = statement(db, QUERY_REMEMBER_BLOB);
    if (!s) return finish(db, s);
    sqlite3_bind_blob(s, 1, source->bytes, DIGEST_BYTES, SQLITE_STATIC);
    sqlite3_bind_blob(s, 2, blob->bytes, DIGEST_BYTES, SQLITE_STATIC);
    const int error = finish(db, s);
    return error ? error : asset_imports_add(db->db, source, assets, asset_count);
}

int job_database_find_blob(struct job_database *db, const struct digest *source,
                           struct digest *blob)
{
    sqlite3_stmt *s = statement(db, QUERY_FIND_BLOB);
    if (!s) return finish(db, s);
    sqlite3_bind_blob(s, 1, source->bytes, DIGEST_BYTES, SQLITE_STATIC);
    int code = sqlite3_step(s), error = error_of(db, code);
    if (code == SQLITE_DONE) error = ERR_NOT_FOUND;
    if (code == SQLITE_ROW && !job_record_digest(s, 0, blob)) error = ERR_CORRUPT;
    sqlite3_reset(s);
    return error;
}

/* -- reading jobs -- */

static int read_frames(struct job_database *db, struct job_record *job)
{
    sqlite3_stmt *s = statement(db, QUERY_FRAMES);
    if (!s) return finish(db, s);
    bind_text(s, 1, job->row.id);
    int code, error = 0;
    while (!error && (code = sqlite3_step(s)) != SQLITE_DONE) {
        error = code == SQLITE_ROW ? job_record_add_frame(job, s) : error_of(db, code);
    }
    sqlite3_reset(s);
    return error;
}

static int read_jobs(struct job_database *db, sqlite3_stmt *s, bool frames, struct job_records *out)
{
    int code, error = 0;
    while (!error && (code = sqlite3_step(s)) != SQLITE_DONE) {
        error = code == SQLITE_ROW ? job_records_add(out, s) : error_of(db, code);
    }
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    for (size_t i = 0; !error && frames && i < out->count; i++) {
        error = read_frames(db, &out->items[i]);
    }
    return error;
}

int job_database_get(struct job_database *db, const char *id, struct job_records *out)
{
    sqlite3_stmt *s = statement(db, QUERY_GET);
    if (!s) return finish(db, s);
    bind_text(s, 1, id);
    return read_jobs(db, s, true, out);
}

int job_database_list(struct job_database *db, const struct job_listing *listing,
                      struct job_records *out)
{
    const enum query all = listing->state ? QUERY_LIST_STATE : QUERY_LIST;
    const enum query own = listing->state ? QUERY_LIST_OWNER_STATE : QUERY_LIST_OWNER;
    sqlite3_stmt *s = statement(db, listing->owner ? own : all);
    if (!s) return finish(db, s);
    bind_text(s, 1, listing->cursor);
    sqlite3_bind_int64(s, 2, (sqlite3_int64)listing->limit + 1); /* one more, to know of more */
    bind_text(s, 3, listing->text);
    if (listing->state) bind_text(s, 4, listing->state);
    if (listing->owner) bind_text(s, 5, listing->owner);
    bind_text(s, 6, listing->name);
    bind_text(s, 7, listing->label);
    int error = read_jobs(db, s, false, out);
    out->more = out->count > listing->limit;
    return error;
}

int job_database_unfinished(struct job_database *db, struct job_records *out)
{
    sqlite3_stmt *s = statement(db, QUERY_UNFINISHED);
    return s ? read_jobs(db, s, true, out) : finish(db, s);
}
