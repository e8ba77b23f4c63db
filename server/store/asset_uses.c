#include "server/store/asset_uses.h"

#include <string.h>

#include "server/store/job_record.h"
#include "server/store/job_schema.h"

/* As ranges, which an index finds: documents of jobs that have ended are not even read past. */
#define UNFINISHED                                                                                 \
    "(state < 'cancelled' OR (state > 'cancelled' AND state < 'failed')"                           \
    " OR (state > 'failed' AND state < 'finished') OR state > 'finished')"

static void bind_digest(sqlite3_stmt *s, int at, const struct digest *d)
{
    sqlite3_bind_blob(s, at, d->bytes, DIGEST_BYTES, SQLITE_STATIC);
}

/* NULL when it cannot be prepared: *error says why. */
static sqlite3_stmt *prepare(sqlite3 *db, const char *query, int *error)
{
    sqlite3_stmt *s = NULL;
    *error = job_schema_error(sqlite3_prepare_v2(db, query, -1, &s, NULL));
    return s;
}

/* A text search over what has not ended, and everything else waits for it: 10,000 jobs of 600 bytes
 * take some 20 ms, 200 MB of documents a quarter of a second, and LIMIT_JOBS_WAITING documents of
 * LIMIT_JOB_BYTES would take minutes. Nobody asks often. A digest in a document's other texts
 * counts, too: it is in nobody's way. */
int asset_uses_jobs(sqlite3 *db, const char *owner, const struct digest *asset,
                    struct asset_users *out)
{
    char hex[DIGEST_HEX_BYTES];
    int error, code;
    *out = (struct asset_users){0};
    sqlite3_stmt *s = prepare(db,
                              "SELECT id FROM jobs WHERE " UNFINISHED
                              " AND (?1 IS NULL OR owner = ?1) AND instr(document, ?2) > 0"
                              " ORDER BY +id", /* by another index than that of ids */
                              &error);
    if (!s) return error;
    digest_to_hex(asset, hex);
    if (owner) sqlite3_bind_text(s, 1, owner, -1, SQLITE_STATIC);
    sqlite3_bind_text(s, 2, hex, -1, SQLITE_STATIC);
    while ((code = sqlite3_step(s)) == SQLITE_ROW) {
        if (out->count < ASSET_USERS_NAMED) job_record_id(s, 0, out->ids[out->count]);
        out->count++;
    }
    sqlite3_finalize(s);
    return job_schema_error(code);
}

bool asset_uses_is_derived(sqlite3 *db, const struct digest *object)
{
    int error;
    sqlite3_stmt *s = prepare(db,
                              "SELECT EXISTS (SELECT 1 FROM frames WHERE exr = ?1)"
                              " OR EXISTS (SELECT 1 FROM frames WHERE png = ?1)"
                              " OR EXISTS (SELECT 1 FROM blobs WHERE blob = ?1)",
                              &error);
    if (!s) return true;
    bind_digest(s, 1, object);
    const bool is_free = sqlite3_step(s) == SQLITE_ROW && sqlite3_column_int(s, 0) == 0;
    sqlite3_finalize(s);
    return !is_free;
}

int asset_uses_note_import(sqlite3 *db, const struct digest *source, const struct digest *assets,
                           size_t count)
{
    int error;
    sqlite3_stmt *s =
        prepare(db, "INSERT OR IGNORE INTO blob_assets (source, asset) VALUES (?1, ?2)", &error);
    if (!s) return error;
    bind_digest(s, 1, source);
    for (size_t i = 0; !error && i < count; i++) {
        bind_digest(s, 2, &assets[i]);
        error = job_schema_error(sqlite3_step(s));
        sqlite3_reset(s);
    }
    sqlite3_finalize(s);
    return error;
}

static int each_digest(sqlite3_stmt *s, asset_uses_found each, void *ctx)
{
    struct digest d;
    int code, error = 0;
    while (!error && (code = sqlite3_step(s)) != SQLITE_DONE) {
        if (code != SQLITE_ROW)
            error = job_schema_error(code);
        else if (job_record_digest(s, 0, &d))
            error = each(ctx, &d);
    }
    sqlite3_finalize(s);
    return error;
}

int asset_uses_each_blob(sqlite3 *db, const struct digest *asset, asset_uses_found each, void *ctx)
{
    int error;
    sqlite3_stmt *s = prepare(db,
                              "SELECT DISTINCT blobs.blob FROM blobs JOIN blob_assets"
                              " ON blob_assets.source = blobs.source WHERE blob_assets.asset = ?1",
                              &error);
    if (!s) return error;
    bind_digest(s, 1, asset);
    return each_digest(s, each, ctx);
}

int asset_uses_each_read(sqlite3 *db, asset_uses_found each, void *ctx)
{
    int error;
    sqlite3_stmt *s = prepare(db, "SELECT DISTINCT asset FROM blob_assets", &error);
    return s ? each_digest(s, each, ctx) : error;
}

int asset_uses_forget_imports(sqlite3 *db, const struct digest *asset)
{
    int error;
    sqlite3_stmt *s = prepare(db,
                              "DELETE FROM blobs WHERE source IN"
                              " (SELECT source FROM blob_assets WHERE asset = ?1)",
                              &error);
    if (!s) return error;
    bind_digest(s, 1, asset);
    error = job_schema_error(sqlite3_step(s));
    sqlite3_finalize(s);
    return error;
}
