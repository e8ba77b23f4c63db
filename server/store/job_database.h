#pragma once
/* The queries of the job store, blocking. One connection, one thread at a time. job_store.h says
 * what they mean; job_store.c runs them elsewhere than on the loop. */
#include "server/store/job_record.h"

struct job_database;

/* ephemeral: no change waits for the disk. */
int job_database_open(const char *path, bool ephemeral, struct job_database **out);
void job_database_close(struct job_database **db);

/* Between batches, before anything else: opens it anew after a file of it failed. SQLite goes on
 * with what it could open then, for reading alone if need be, for as long as a connection lasts. So
 * does this while the disk fails: then its error comes back, and what is read may still be asked
 * for if job_database_is_open. */
int job_database_refresh(struct job_database *db, bool to_write);
bool job_database_is_open(const struct job_database *db);
/* For what is asked elsewhere: borrowed until the next refresh. What comes of it is told here. */
sqlite3 *job_database_connection(struct job_database *db);
void job_database_note(struct job_database *db, int error);

/* A batch of changes that becomes durable as one. Inside it, mark/unmark frame one change, so that
 * a failed one leaves nothing behind. */
int job_database_begin(struct job_database *db);
int job_database_commit(struct job_database *db);
void job_database_rollback(struct job_database *db);
bool job_database_in_batch(const struct job_database *db); /* false: SQLite has rolled it back */
int job_database_mark(struct job_database *db);
void job_database_unmark(struct job_database *db, bool keep);

/* ERR_EXISTS with `existing`, ERR_MISMATCH: see job_store_insert. */
int job_database_insert(struct job_database *db, const struct job_row *row, const char *key,
                        const struct digest *body, char existing[JOB_ID_BYTES]);
int job_database_find_key(struct job_database *db, const char *owner, const char *key,
                          const struct digest *body, char existing[JOB_ID_BYTES]);
/* ERR_NOT_FOUND when there is no such job, here and below. */
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

/* Each fills an empty *out; job_records_fini in any case. */
int job_database_get(struct job_database *db, const char *id, struct job_records *out);
int job_database_list(struct job_database *db, const struct job_listing *listing,
                      struct job_records *out);
int job_database_unfinished(struct job_database *db, struct job_records *out);
