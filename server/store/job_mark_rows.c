#include "server/store/job_mark_rows.h"

#include "server/store/job_schema.h"

int job_mark_rows_add(sqlite3 *db, const struct job_row *row)
{
    sqlite3_stmt *s = NULL;
    if (!row->name && !row->labels) return 0;
    int code = sqlite3_prepare_v2(db, "INSERT INTO marks (job, name, labels) VALUES (?1, ?2, ?3)",
                                  -1, &s, NULL);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 1, row->id, -1, SQLITE_STATIC);
    if (code == SQLITE_OK && row->name)
        code = sqlite3_bind_text(s, 2, row->name, -1, SQLITE_STATIC);
    if (code == SQLITE_OK && row->labels)
        code = sqlite3_bind_text(s, 3, row->labels, -1, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    sqlite3_finalize(s);
    return job_schema_error(code);
}

/* A member of the change that is not there leaves the document's as it is. The revision is where
 * jobs_get finds that of a job that is not in work. */
#define CHANGED(document, member)                                                                  \
    "CASE WHEN json_type(?2, '$." member "') IS NULL THEN " document " ELSE json_set(" document    \
    ", '$." member "', json_extract(?2, '$." member "')) END"
#define WITH_NAME    CHANGED("document", "name")
#define WITH_COMMENT CHANGED("(" WITH_NAME ")", "comment")
#define REVISION     "coalesce(json_extract(report, '$.revision'), updated_ms)"

static const char change_document[] = "UPDATE jobs SET document = " CHANGED(
    "(" WITH_COMMENT ")",
    "labels") ","
              " report = CASE WHEN json_type(report, '$.revision') IS NULL THEN report"
              " ELSE json_set(report, '$.revision', json_extract(report, '$.revision') + 1) END,"
              " updated_ms = updated_ms + 1"
              " WHERE id = ?1 AND (?3 IS NULL OR owner = ?3) AND (?4 = 0 OR " REVISION " = ?4)";

static const char change_row[] =
    "INSERT INTO marks (job, name, labels) SELECT id, json_extract(document, '$.name'),"
    " (SELECT char(10) || group_concat(value, char(10)) || char(10)"
    "  FROM json_each(document, '$.labels')) FROM jobs WHERE id = ?1"
    " ON CONFLICT (job) DO UPDATE SET name = excluded.name, labels = excluded.labels";

static int prepare(sqlite3 *db, const char *text, const char *id, sqlite3_stmt **s)
{
    const int code = sqlite3_prepare_v2(db, text, -1, s, NULL);
    return code == SQLITE_OK ? sqlite3_bind_text(*s, 1, id, -1, SQLITE_STATIC) : code;
}

int job_mark_rows_change(sqlite3 *db, const char *id, const char *owner, uint64_t seen_revision,
                         const char *marks)
{
    sqlite3_stmt *s = NULL;
    int code = prepare(db, change_document, id, &s);
    if (code == SQLITE_OK) code = sqlite3_bind_text(s, 2, marks, -1, SQLITE_STATIC);
    if (code == SQLITE_OK && owner) code = sqlite3_bind_text(s, 3, owner, -1, SQLITE_STATIC);
    if (code == SQLITE_OK) code = sqlite3_bind_int64(s, 4, (sqlite3_int64)seen_revision);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    sqlite3_finalize(s);
    int error = job_schema_error(code);
    if (error) return error;
    if (sqlite3_changes(db) == 0) return seen_revision ? ERR_MISMATCH : ERR_NOT_FOUND;
    code = prepare(db, change_row, id, &s);
    if (code == SQLITE_OK) code = sqlite3_step(s);
    sqlite3_finalize(s);
    return job_schema_error(code);
}
