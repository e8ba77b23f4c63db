#include "server/store/asset_tables.h"

#include <stdlib.h>
#include <string.h>

#include "server/store/job_record.h"
#include "server/store/job_schema.h"

/* The unfinished states as ranges, which an index finds, so that documents of ended jobs are not
 * read. */
#define UNFINISHED                                                                                 \
    "(state < 'cancelled' OR (state > 'cancelled' AND state < 'failed')"                           \
    " OR (state > 'failed' AND state < 'finished') OR state > 'finished')"

/* Prepares a query and binds ?1 to an owner, ?2 to a digest and ?3 to a number, as far as it has
 * them. Returns NULL, with the reason in *error, if it cannot. Bound values must outlive it. */
static sqlite3_stmt *prepare(sqlite3 *db, const char *query, const char *owner,
                             const struct digest *d, int64_t number, int *error)
{
    sqlite3_stmt *s = NULL;
    *error = job_schema_error(sqlite3_prepare_v2(db, query, -1, &s, NULL));
    if (!s) return NULL;
    if (owner) sqlite3_bind_text(s, 1, owner, -1, SQLITE_STATIC);
    if (d) sqlite3_bind_blob(s, 2, d->bytes, DIGEST_BYTES, SQLITE_STATIC);
    if (sqlite3_bind_parameter_count(s) >= 3) sqlite3_bind_int64(s, 3, number);
    return s;
}

/* Runs it; *out (may be NULL) is the number that it gives. */
static int ask(sqlite3 *db, const char *query, const char *owner, const struct digest *d,
               int64_t number, int64_t *out)
{
    int error;
    sqlite3_stmt *s = prepare(db, query, owner, d, number, &error);
    if (!s) return error;
    const int code = sqlite3_step(s);
    if (code == SQLITE_ROW && out) *out = sqlite3_column_int64(s, 0);
    sqlite3_finalize(s);
    return job_schema_error(code);
}

static int change(sqlite3 *db, const char *query, const char *owner, const struct digest *d)
{
    return ask(db, query, owner, d, 0, NULL);
}

/* Runs a query that says whether there is such a row. */
static int find(sqlite3 *db, const char *query, const char *owner, const struct digest *d)
{
    int64_t found = 0;
    const int error = ask(db, query, owner, d, 0, &found);
    return error || found ? error : ERR_NOT_FOUND;
}

int asset_tables_begin(sqlite3 *db)
{
    return change(db, "BEGIN IMMEDIATE", NULL, NULL);
}

int asset_tables_end(sqlite3 *db, int error)
{
    if (!error) error = change(db, "COMMIT", NULL, NULL);
    if (error) (void)change(db, "ROLLBACK", NULL, NULL); /* where SQLite has not done so itself */
    return error;
}

int asset_owners_add(sqlite3 *db, const char *owner, const struct digest *asset,
                     uint64_t size_bytes, bool *existed)
{
    const int error =
        ask(db, "INSERT OR IGNORE INTO asset_owners (owner, asset, bytes) VALUES (?1, ?2, ?3)",
            owner, asset, (int64_t)size_bytes, NULL);
    *existed = !error && sqlite3_changes(db) == 0;
    return error;
}

int asset_owners_drop(sqlite3 *db, const char *owner, const struct digest *asset)
{
    return change(db, "DELETE FROM asset_owners WHERE asset = ?2 AND owner = coalesce(?1, owner)",
                  owner, asset);
}

int asset_owners_find(sqlite3 *db, const char *owner, const struct digest *asset)
{
    return find(db, "SELECT EXISTS (SELECT 1 FROM asset_owners WHERE owner = ?1 AND asset = ?2)",
                owner, asset);
}

/* Lists owners by walking the few tenants and not the many assets. Without another index a commit
 * of one row writes one page. */
#define OWNERS                                                                                     \
    "WITH RECURSIVE owners (name) AS (SELECT min(owner) FROM asset_owners UNION ALL"               \
    " SELECT (SELECT min(owner) FROM asset_owners WHERE owner > name) FROM owners"                 \
    " WHERE name IS NOT NULL) "

int asset_owners_find_other(sqlite3 *db, const char *owner, const struct digest *asset)
{
    return find(db,
                OWNERS "SELECT EXISTS (SELECT 1 FROM owners CROSS JOIN asset_owners"
                       " ON owner = name AND asset = ?2 WHERE name IS NOT ?1)",
                owner, asset);
}

/* Walks over the owner's rows, some 10 ms for 100,000 of them. */
int asset_owners_sum(sqlite3 *db, const char *owner, uint64_t *size_bytes)
{
    int64_t sum = 0;
    const int error = ask(db, "SELECT coalesce(sum(bytes), 0) FROM asset_owners WHERE owner = ?1",
                          owner, NULL, 0, &sum);
    *size_bytes = (uint64_t)sum;
    return error;
}

int asset_removals_add(sqlite3 *db, const struct digest *object)
{
    return change(db, "INSERT OR IGNORE INTO removals (object) VALUES (?2)", NULL, object);
}

int asset_removals_drop(sqlite3 *db, const struct digest *object)
{
    return change(db, "DELETE FROM removals WHERE object = ?2", NULL, object);
}

int asset_removals_find(sqlite3 *db, const struct digest *object)
{
    return find(db, "SELECT EXISTS (SELECT 1 FROM removals WHERE object = ?2)", NULL, object);
}

int asset_removals_count(sqlite3 *db, size_t *count)
{
    int64_t rows = 0;
    const int error = ask(db, "SELECT count(*) FROM removals", NULL, NULL, 0, &rows);
    *count = (size_t)rows;
    return error;
}

/* A text search over what has not ended, and everything else waits for it: 10,000 jobs of 600 bytes
 * take some 20 ms, 200 MB of documents a quarter of a second, and LIMIT_JOBS_WAITING documents of
 * LIMIT_JOB_BYTES would take minutes. It is rare. A digest in a document's other texts counts, too,
 * which does no harm. */
int asset_users_find(sqlite3 *db, const char *owner, const struct digest *asset,
                     struct asset_users *out)
{
    int error, code;
    *out = (struct asset_users){0};
    sqlite3_stmt *s =
        prepare(db,
                "SELECT id FROM jobs WHERE " UNFINISHED " AND (?1 IS NULL OR owner = ?1)"
                " AND instr(document, lower(hex(?2))) > 0"
                " ORDER BY +id", /* by another index than that of ids */
                owner, asset, 0, &error);
    if (!s) return error;
    while ((code = sqlite3_step(s)) == SQLITE_ROW) {
        if (out->count < ASSET_USERS_NAMED) job_record_id(s, 0, out->ids[out->count]);
        out->count++;
    }
    sqlite3_finalize(s);
    return job_schema_error(code);
}

bool asset_is_derived(sqlite3 *db, const struct digest *object)
{
    return find(db,
                "SELECT EXISTS (SELECT 1 FROM frames WHERE exr = ?2)"
                " OR EXISTS (SELECT 1 FROM frames WHERE png = ?2)"
                " OR EXISTS (SELECT 1 FROM blobs WHERE blob = ?2)",
                NULL, object) != ERR_NOT_FOUND;
}

int asset_imports_add(sqlite3 *db, const struct digest *source, const struct digest *assets,
                      size_t count)
{
    int error;
    sqlite3_stmt *s =
        prepare(db, "INSERT OR IGNORE INTO blob_assets (asset, source) VALUES (?1, ?2)", NULL,
                source, 0, &error);
    if (!s) return error;
    for (size_t i = 0; !error && i < count; i++) {
        sqlite3_bind_blob(s, 1, assets[i].bytes, DIGEST_BYTES, SQLITE_STATIC);
        error = job_schema_error(sqlite3_step(s));
        sqlite3_reset(s);
    }
    sqlite3_finalize(s);
    return error;
}

#define READERS "(SELECT source FROM blob_assets WHERE asset = ?2)"

int asset_imports_drop(sqlite3 *db, const struct digest *asset)
{
    const int error = change(db,
                             "INSERT OR IGNORE INTO removals (object)"
                             " SELECT blob FROM blobs WHERE source IN " READERS,
                             NULL, asset);
    return error ? error : change(db, "DELETE FROM blobs WHERE source IN " READERS, NULL, asset);
}

static int append(struct digest_list *list, const struct digest *d)
{
    struct digest *grown = realloc(list->items, (list->count + 1) * sizeof *grown);
    if (!grown) return ERR_MEMORY;
    list->items = grown;
    list->items[list->count++] = *d;
    return 0;
}

static int list_rows(sqlite3 *db, const char *query, const struct digest *d, int64_t number,
                     struct digest_list *out)
{
    struct digest found;
    int error, code;
    sqlite3_stmt *s = prepare(db, query, NULL, d, number, &error);
    while (!error && (code = sqlite3_step(s)) != SQLITE_DONE) {
        if (code != SQLITE_ROW)
            error = job_schema_error(code);
        else if (job_record_digest(s, 0, &found))
            error = append(out, &found);
    }
    sqlite3_finalize(s);
    return error;
}

int asset_list_owned(sqlite3 *db, struct digest_list *out)
{
    return list_rows(db, "SELECT DISTINCT asset FROM asset_owners", NULL, 0, out);
}

int asset_list_blobs(sqlite3 *db, const struct digest *asset, struct digest_list *out)
{
    return list_rows(db, "SELECT DISTINCT blob FROM blobs WHERE source IN " READERS, asset, 0, out);
}

int asset_list_removals(sqlite3 *db, const struct digest *after, size_t limit,
                        struct digest_list *out)
{
    return list_rows(db,
                     "SELECT object FROM removals WHERE ?2 IS NULL OR object > ?2"
                     " ORDER BY object LIMIT ?3",
                     after, limit < INT64_MAX ? (int64_t)limit : INT64_MAX, out);
}
