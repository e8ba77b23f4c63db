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
