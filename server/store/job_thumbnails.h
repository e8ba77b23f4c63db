#pragma once
/* The small picture of each job that has ended, in a table beside the jobs: it goes with its row.
 */
#include <sqlite3.h>
#include <stddef.h>

/* Keeps a PNG; the first is kept for good. Without such a job nothing happens. ERR_* of
 * job_schema.h. */
int job_thumbnails_keep(sqlite3 *db, const char *id, const void *png, size_t size_bytes);

/* Finds it: *png is malloc'ed, NULL where there is none. */
int job_thumbnails_find(sqlite3 *db, const char *id, void **png, size_t *size_bytes);
