#include "server/store/job_queries.h"

#include "server/store/job_record.h"

/* No LIKE: what people look for may hold its wildcards. */
#define HAS_TEXT                                                                                   \
    " AND (?3 IS NULL OR instr(lower(id), lower(?3)) > 0 OR instr(lower(document), lower(?3)) > "  \
    "0)"

/* What is marked so is found in the marks alone, which are small beside documents and reports. */
#define HAS_MARKS                                                                                  \
    " AND ((?6 IS NULL AND ?7 IS NULL) OR id IN (SELECT job FROM marks WHERE"                      \
    " (?6 IS NULL OR instr(lower(name), lower(?6)) > 0) AND"                                       \
    " (?7 IS NULL OR instr(labels, char(10) || ?7 || char(10)) > 0)))"

static const char *const query_text[QUERY_COUNT] = {
    [QUERY_BEGIN] = "BEGIN IMMEDIATE",
    [QUERY_COMMIT] = "COMMIT",
    [QUERY_ROLLBACK] = "ROLLBACK",
    [QUERY_MARK] = "SAVEPOINT change",
    [QUERY_KEEP] = "RELEASE change",
    [QUERY_UNDO] = "ROLLBACK TO change",
    [QUERY_FIND_KEY] = "SELECT body, job FROM keys WHERE key = ?1",
    [QUERY_INSERT] =
        "INSERT INTO jobs (" JOB_RECORD_OWN_COLUMNS ") VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9,"
        " ?10, ?11)",
    [QUERY_INSERT_KEY] = "INSERT INTO keys (key, body, job) VALUES (?1, ?2, ?3)",
    [QUERY_UPDATE] = "UPDATE jobs SET state = coalesce(?2, state), error = coalesce(?3, error),"
                     " report = coalesce(?4, report), updated_ms = ?5 WHERE id = ?1",
    [QUERY_STEER] = "UPDATE jobs SET priority = coalesce(?2, priority),"
                    " paused = coalesce(?3, paused), updated_ms = ?4 WHERE id = ?1"
                    " AND state NOT IN ('finished', 'failed', 'cancelled')",
    [QUERY_UPDATE_FRAME] = "INSERT INTO frames (job, number, state, exr, png)"
                           " SELECT id, ?2, ?3, ?4, ?5 FROM jobs WHERE id = ?1"
                           " ON CONFLICT (job, number) DO UPDATE SET state = excluded.state,"
                           " exr = excluded.exr, png = excluded.png",
    [QUERY_UPDATE_DOCUMENT] =
        "UPDATE jobs SET document = json_set(?2, '$.name', json_extract(document, '$.name'),"
        " '$.comment', json_extract(document, '$.comment'),"
        " '$.labels', json(coalesce(json_extract(document, '$.labels'), '[]'))),"
        " updated_ms = ?3 WHERE id = ?1",
    [QUERY_REMOVE] = "DELETE FROM jobs WHERE id = ?1",
    [QUERY_GET] = "SELECT " JOB_RECORD_COLUMNS " FROM jobs WHERE id = ?1",
    [QUERY_FRAMES] = "SELECT " JOB_RECORD_FRAME_COLUMNS " FROM frames WHERE job = ?1"
                     " ORDER BY number",
    [QUERY_LIST] =
        "SELECT " JOB_RECORD_COLUMNS " FROM jobs WHERE (?1 IS NULL OR id < ?1)" HAS_TEXT HAS_MARKS
        " ORDER BY id DESC LIMIT ?2",
    [QUERY_LIST_STATE] =
        "SELECT " JOB_RECORD_COLUMNS " FROM jobs WHERE state = ?4"
        " AND (?1 IS NULL OR id < ?1)" HAS_TEXT HAS_MARKS " ORDER BY id DESC LIMIT ?2",
    [QUERY_LIST_OWNER] =
        "SELECT " JOB_RECORD_COLUMNS " FROM jobs WHERE owner = ?5"
        " AND (?1 IS NULL OR id < ?1)" HAS_TEXT HAS_MARKS " ORDER BY id DESC LIMIT ?2",
    [QUERY_LIST_OWNER_STATE] = "SELECT " JOB_RECORD_COLUMNS " FROM jobs WHERE owner = ?5"
                               " AND state = ?4 AND (?1 IS NULL OR id < ?1)" HAS_TEXT HAS_MARKS
                               " ORDER BY id DESC LIMIT ?2",
    [QUERY_UNFINISHED] = "SELECT " JOB_RECORD_COLUMNS " FROM jobs"
                         " WHERE state NOT IN ('finished', 'failed', 'cancelled') ORDER BY id",
    [QUERY_REMEMBER_BLOB] = "INSERT INTO blobs (source, blob) VALUES (?1, ?2)"
                            " ON CONFLICT (source) DO UPDATE SET blob = excluded.blob",
    [QUERY_FIND_BLOB] = "SELECT blob FROM blobs WHERE source = ?1",
};

const char *job_query_text(enum query query)
{
    return query_text[query];
}
