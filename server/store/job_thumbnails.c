#include "server/store/job_thumbnails.h"

#include <stdlib.h>
#include <string.h>

#include "proto/error.h"
#include "server/store/job_schema.h"
#include "server/store/job_store_internal.h"

int job_thumbnails_keep(sqlite3 *db, const char *id, const void *png, size_t size_bytes)
{
    sqlite3_stmt *s = NULL;
    int code = sqlite3_prepare_v2(db,
                                  "INSERT INTO thumbnails (job, png) SELECT id, ?2 FROM jobs"
                                  " WHERE id = ?1 ON CONFLICT (job) DO NOTHING",
                                  -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_bind_blob64(s, 2, png, size_bytes, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    sqlite3_finalize(s);
    return job_schema_error(code);
}

static int copy_blob(sqlite3_stmt *s, void **png, size_t *size_bytes)
{
    const void *bytes = sqlite3_column_blob(s, 0);
    *size_bytes = (size_t)sqlite3_column_bytes(s, 0);
    *png = malloc(*size_bytes + 1);
    if (!*png) return ERR_MEMORY;
    if (bytes) memcpy(*png, bytes, *size_bytes);
    return 0;
}

int job_thumbnails_find(sqlite3 *db, const char *id, void **png, size_t *size_bytes)
{
    sqlite3_stmt *s = NULL;
    *png = NULL;
    *size_bytes = 0;
    int code = sqlite3_prepare_v2(db, "SELECT png FROM thumbnails WHERE job = ?1", -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    const int error = code == SQLITE_ROW ? copy_blob(s, png, size_bytes) : job_schema_error(code);
    sqlite3_finalize(s);
    return error;
}

void job_store_keep_thumbnail(struct job_store *s, const char *id, const void *png,
                              size_t size_bytes)
{
    struct job_request *r = job_request_create(REQUEST_KEEP_THUMBNAIL, id, NULL);
    if (!r) return; /* the next look makes it anew */
    r->png = malloc(size_bytes + 1);
    r->png_bytes = size_bytes;
    if (r->png) memcpy(r->png, png, size_bytes);
    job_batches_submit(&s->batches, r, r->png ? 0 : ERR_MEMORY);
}

void job_store_find_thumbnail(struct job_store *s, const char *id, job_store_pictured done,
                              void *ctx)
{
    struct job_request *r = job_request_create(REQUEST_FIND_THUMBNAIL, id, ctx);
    if (!r) {
        done(ctx, ERR_MEMORY, NULL, 0);
        return;
    }
    r->call.pictured = done;
    job_batches_submit(&s->batches, r, 0);
}
