#pragma once
/* The queries of the job store, on one connection. They block, and are for one thread at a time.
 * job_store.h says what they mean; job_store.c keeps them off the loop's thread. */
#include "server/store/job_record.h"

struct job_database;

/* Opens the database. ephemeral: no change waits for the disk. */
int job_database_open(const char *path, bool ephemeral, struct job_database **out);
void job_database_close(struct job_database **db);

/* Opens the database anew after one of its files has failed. It must come first between batches,
 * since SQLite keeps what it could open for as long as a connection lasts, for reading alone if
 * need be. While the disk fails, this returns the disk's error and keeps the old connection. Reads
 * may still be tried if job_database_is_open. */
int job_database_refresh(struct job_database *db, bool to_write);
bool job_database_is_open(const struct job_database *db);
/* Returns the connection for queries of other files, borrowed until the next refresh.
 * job_database_note is told how they ended. */
sqlite3 *job_database_connection(struct job_database *db);
void job_database_note(struct job_database *db, int error);

/* Begin and end a batch of changes, which becomes durable as one. Inside it, mark and unmark
 * enclose one change, so that a failed one leaves nothing behind. */
int job_database_begin(struct job_database *db);
int job_database_commit(struct job_database *db);
void job_database_rollback(struct job_database *db);
bool job_database_in_batch(const struct job_database *db); /* false: SQLite has rolled it back */
int job_database_mark(struct job_database *db);
void job_database_unmark(struct job_database *db, bool keep);

/* Insert a job, and find one by its key. job_store_insert explains ERR_EXISTS with `existing` and
 * ERR_MISMATCH. */
int job_database_insert(struct job_database *db, const struct job_row *row, const char *key,
                        const struct digest *body, char existing[JOB_ID_BYTES]);
int job_database_find_key(struct job_database *db, const char *owner, const char *key,
                          const struct digest *body, char existing[JOB_ID_BYTES]);
/* Change, remove and remember. ERR_NOT_FOUND when there is no such job, here and below. */
int job_database_update(struct job_database *db, const char *id, const char *state,
                        const char *error, const char *report);
int job_database_steer(struct job_database *db, const char *id, const int32_t *priority,
                       const bool *paused);
int job_database_update_frame(struct job_database *db, const char *id,
                              const struct frame_row *frame);
int job_database_update_document(struct job_database *db, const char *id, const char *document);
int job_database_remove(struct job_database *db, const char *id);
int job_database_remember_blob(struct job_database *db, const struct digest *source,
                               const struct digest *blob, const struct digest *assets,
                               size_t asset_count);
int job_database_find_blob(struct job_database *db, const struct digest *source,
                           struct digest *blob);

/* Fill an empty *out, which needs job_records_fini in any case. */
int job_database_get(struct job_database *db, const char *id, struct job_records *out);
int job_database_list(struct job_database *db, const struct job_listing *listing,
                      struct job_records *out);
int job_database_unfinished(struct job_database *db, struct job_records *out);
