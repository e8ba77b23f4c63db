#pragma once
/* Names and labels of jobs, in a table beside them: small, so that a search reads no documents. */
#include <sqlite3.h>

#include "server/store/job_store.h"

/* Adds those of a row that is new; a job without any has none. */
int job_mark_rows_add(sqlite3 *db, const struct job_row *row);

/* Changes a job's document as job_store_mark says, and the table with it. */
int job_mark_rows_change(sqlite3 *db, const char *id, const char *owner, uint64_t seen_revision,
                         const char *marks);
