#pragma once
/* Opens the database of jobs, and migrates an older schema. */
#include <sqlite3.h>
#include <stdbool.h>

/* Opens or creates `path`: WAL, synchronous=FULL (ephemeral: OFF), foreign keys, the newest schema.
 * The connection has no mutex of its own, so it is for one thread at a time. ERR_IO, ERR_VERSION
 * for a schema from a newer program, ERR_CORRUPT for a file that is no database. */
int job_schema_open(const char *path, bool ephemeral, sqlite3 **out);

/* Tests whether a file beside the database can be created, written and synced now. 0, ERR_NO_SPACE,
 * ERR_IO. */
int job_schema_probe(const char *path);

/* Returns the error code for an SQLite result. */
int job_schema_error(int sqlite_code);
