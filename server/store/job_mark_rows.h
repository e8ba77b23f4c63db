#pragma once
/* Names and labels of jobs, in a table beside them: small, so that a search reads no documents. */
#include <sqlite3.h>

#include "server/store/job_store.h"

/* Adds those of a row that is new; a job without any has none. */
int job_mark_rows_add(sqlite3 *db, const struct job_row *row);
