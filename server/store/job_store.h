#pragma once
/* Jobs on disk: SQLite in WAL mode. Every change of a job's state is a synced commit.
 *
 * Queries run on the store's own thread (a pool of one, so in order), and callbacks come on the
 * loop's thread. Text handed in is copied; text in callbacks is borrowed for the call. */
#include <stdbool.h>
#include <uv.h>

#include "proto/digest.h"
#include "proto/error.h"
#include "proto/limits.h"
#include "proto/log/trace_context.h"
#include "server/metric/duration_histogram.h"
#include "server/store/objects.h"

struct job_store;

#define JOB_ID_BYTES    27 /* 26 characters and the end */
#define JOB_OWNER_BYTES 65 /* a tenant's name: 1 to 64 of a-z, 0-9, '-', '_', and the end */

/* One row of `jobs`. All pointers may be NULL for SQL NULL. */
struct job_row {
    char id[JOB_ID_BYTES]; /* sorts by time of creation */
    const char *document;  /* job_write's JSON */
    const char
        *state; /* "queued" "importing" "running" "resting" "finished" "failed" "cancelled" */
    const char *error;  /* problem JSON of a failed job */
    const char *report; /* JSON: plan, statistics, warnings, frames, as far as known */
    int64_t created_ms, updated_ms;
    int32_t priority;
    bool paused;
    char owner[JOB_OWNER_BYTES]; /* the tenant that submitted it; "": before there were tenants */
    char trace[TRACE_CONTEXT_TEXT_BYTES]; /* of the request that submitted it (trace_context_keep);
                                             "": not known */
    const char *name;                     /* the document's */
    const char *labels;                   /* the document's, each between line breaks: "\na\nb\n" */
    const char *webhook;                  /* the document's; not read back */
    struct digest png; /* read only: of the last frame that has one; zero: none */
};

/* One row of `frames`. */
struct frame_row {
    int32_t number;
    const char *state;      /* "queued" "rendering" "encoding" "finished" */
    struct digest exr, png; /* objects; zero until finished */
};

/* Opens or creates DIR/jobs.sqlite and holds DIR/jobs.lock. ERR_IO, ERR_VERSION for a newer schema,
 * ERR_CORRUPT for a file that is no database, ERR_STATE when another process has the folder open.
 * ephemeral: no change waits for the disk, for a folder that goes with its process. */
int job_store_open(uv_loop_t *loop, const char *dir, bool ephemeral, struct job_store **out);

struct job_store_totals {
    struct duration_histogram commits; /* groups of changes, until they are durable or fail */
    uint64_t failures;                 /* of these */
    uint64_t waiting;                  /* waiting requests now */
};
void job_store_totals(const struct job_store *s, struct job_store_totals *out);

/* Lets pending writes finish. Nulls the pointer. The loop must run once more afterwards. */
void job_store_close(struct job_store **store);

typedef void (*job_store_done)(void *ctx, int error);

/* Inserts a job, durable when `done` is called with 0. With idempotency_key (may be NULL; each
 * owner has its own keys), a known key with the same body digest inserts nothing, and done gets
 * ERR_EXISTS with `existing` the first job's id; with another body, ERR_MISMATCH. ERR_STATE when
 * the row's own id is taken. */
typedef void (*job_store_inserted)(void *ctx, int error, const char *existing);
void job_store_insert(struct job_store *s, const struct job_row *row, const char *idempotency_key,
                      const struct digest *body, job_store_inserted done, void *ctx);

/* Assets that must be there for the job's owner (asset_room_find) when the job is inserted.
 * ERR_NOT_FOUND when one of them is not. They are copied. */
struct job_assets {
    const struct digest *items;
    size_t count;
    bool sees_all;
    size_t *missing; /* may be NULL; with ERR_NOT_FOUND the first that is not there */
};
void job_store_submit(struct job_store *s, const struct job_row *row, const char *idempotency_key,
                      const struct digest *body, const struct job_assets *assets,
                      job_store_inserted done, void *ctx);

/* Looks a key up for a client that would be refused a new job: ERR_EXISTS with `existing`,
 * ERR_MISMATCH, 0 for an unknown key. */
void job_store_find_key(struct job_store *s, const char *owner, const char *idempotency_key,
                        const struct digest *body, job_store_inserted done, void *ctx);

/* Sets state, error, report (each if not NULL). ERR_NOT_FOUND when there is no such job, here and
 * below. An update with done NULL may be merged with a waiting one before it, so that at most one
 * waits for each job. */
void job_store_update(struct job_store *s, const char *id, const char *state, const char *error,
                      const char *report, job_store_done done, void *ctx);
/* Sets priority and paused (each if not NULL). ERR_NOT_FOUND for a job that has ended, too. */
void job_store_steer(struct job_store *s, const char *id, const int32_t *priority,
                     const bool *paused, job_store_done done, void *ctx);
/* Sets a frame's row and with it the job's report (if not NULL): both or neither. */
void job_store_update_frame(struct job_store *s, const char *id, const struct frame_row *frame,
                            const char *report, job_store_done done, void *ctx);
/* Changes a job's name, comment and labels, whether or not it has ended. marks: those to change, as
 * job_marks_read_change gives them, in JSON. owner: whose job it must be; NULL: anyone's.
 * seen_revision: that of a job that is not in work, which it must still have (else ERR_MISMATCH);
 * 0: any. */
void job_store_mark(struct job_store *s, const char *id, const char *owner, uint64_t seen_revision,
                    const char *marks, job_store_done done, void *ctx);
/* Replaces the document of a job whose camera was moved, but for its marks. */
void job_store_update_document(struct job_store *s, const char *id, const char *document,
                               job_store_done done, void *ctx);
void job_store_remove(struct job_store *s, const char *id, job_store_done done, void *ctx);

/* Finds a job. row NULL: there is none. frames: those that have a row, by number. */
typedef void (*job_store_found)(void *ctx, int error, const struct job_row *row,
                                const struct frame_row *frames, size_t frame_count);
void job_store_get(struct job_store *s, const char *id, job_store_found done, void *ctx);

/* Keeps a small picture of a job that has ended, until the job is removed. The bytes are copied. */
void job_store_keep_thumbnail(struct job_store *s, const char *id, const void *png,
                              size_t size_bytes);
/* Finds it. png NULL: there is none. Borrowed. */
typedef void (*job_store_pictured)(void *ctx, int error, const void *png, size_t size_bytes);
void job_store_find_thumbnail(struct job_store *s, const char *id, job_store_pictured done,
                              void *ctx);

/* A job that has ended and has yet to be told of (server/webhook). */
struct webhook_row {
    char id[JOB_ID_BYTES], state[16];
    char url[LIMIT_WEBHOOK_URL_BYTES + 1];
    char name[4 * LIMIT_JOB_NAME + 1]; /* "": none */
    uint32_t tries;                    /* that have failed */
    int64_t due_ms;                    /* when it is tried again; 0: now */
};
#define WEBHOOKS_READ 32

/* Finds those that are due first, at most WEBHOOKS_READ. Borrowed. */
typedef void (*job_store_hooked)(void *ctx, int error, const struct webhook_row *rows,
                                 size_t count);
void job_store_list_webhooks(struct job_store *s, job_store_hooked done, void *ctx);
/* Notes that one failed, and when it is tried again; due_ms < 0: it is over and forgotten. */
void job_store_note_webhook(struct job_store *s, const char *id, uint32_t tries, int64_t due_ms,
                            job_store_done done, void *ctx);

/* Selects jobs, newest first. */
struct job_listing {
    const char *state;  /* NULL: any */
    const char *cursor; /* strictly before this id; NULL: from the newest */
    const char *text;   /* in the id or the document, ASCII letters in either case; NULL: any */
    const char *owner;  /* NULL: any */
    const char *name;   /* in the name, ASCII letters in either case; NULL: any */
    const char *label;  /* one of the labels; NULL: any */
    size_t limit;       /* rows, at most LIMIT_LIST_ROWS */
};
/* Lists jobs. A text is searched in all documents while everything else waits: ERR_STATE while that
 * is done for another listing. */
typedef void (*job_store_listed)(void *ctx, int error, const struct job_row *rows, size_t count,
                                 bool more);
void job_store_list(struct job_store *s, const struct job_listing *listing, job_store_listed done,
                    void *ctx);

/* Calls `each` for every job that is not finished, failed or cancelled, oldest first. Blocking, at
 * start-up. The callback's pointers are borrowed; it may submit changes. ERR_STATE while requests
 * are pending. */
int job_store_unfinished(struct job_store *s,
                         void (*each)(void *ctx, const struct job_row *row,
                                      const struct frame_row *frames, size_t frame_count),
                         void *ctx);

/* Finds the greatest id of all jobs; "" without jobs. Blocking, at start-up. ERR_STATE as above. */
int job_store_newest(struct job_store *s, char id[JOB_ID_BYTES]);

/* Remembers which blob an import gave. `source` is a digest over the importer's build, the scene
 * asset and its files, which are `assets`. ERR_NOT_FOUND when one of these has gone meanwhile: the
 * blob goes, too. done may be NULL. */
void job_store_remember_blob(struct job_store *s, const struct digest *source,
                             const struct digest *blob, const struct digest *assets,
                             size_t asset_count, job_store_done done, void *ctx);
typedef void (*job_store_blob)(void *ctx, int error, const struct digest *blob); /* NULL: unknown */
void job_store_find_blob(struct job_store *s, const struct digest *source, job_store_blob done,
                         void *ctx);

/* Sets where assets are, for job_store_submit and the functions below. objects is borrowed;
 * tenant_bytes is the quota of each tenant (0: none). To be called before the loop runs. */
void job_store_set_assets(struct job_store *s, const struct objects *objects,
                          uint64_t tenant_bytes);

/* A user's claim on an asset. */
struct asset_claim {
    struct digest asset;
    char owner[JOB_OWNER_BYTES]; /* "": there are no tokens that tell users apart */
    bool sees_all;
};

/* Puts an upload's owner on record, before its file is placed (asset_room.h). */
typedef void (*job_store_kept)(void *ctx, int error, bool existed);
void job_store_keep_asset(struct job_store *s, const struct asset_claim *claim, uint64_t size_bytes,
                          job_store_kept done, void *ctx);
/* Notes that an asset could not be placed. Once it is not held, it loses its owners unless its file
 * is there. */
void job_store_doubt_asset(struct job_store *s, const struct digest *asset);

/* Finds whether all of these are there for the owner, as job_store_submit does. */
void job_store_find_assets(struct job_store *s, const char *owner, const struct job_assets *assets,
                           job_store_done done, void *ctx);

/* The jobs that keep an asset. */
#define ASSET_USERS_NAMED 4
struct asset_users {
    size_t count;
    char ids[ASSET_USERS_NAMED][JOB_ID_BYTES]; /* the oldest of them */
};

/* Gives an asset up. asset_removal.h says when that is possible, and what goes with it. users is
 * borrowed. */
typedef void (*job_store_gave_up)(void *ctx, int error, const struct asset_users *users);
void job_store_remove_asset(struct job_store *s, const struct asset_claim *claim,
                            job_store_gave_up done, void *ctx);

/* Ends removals that a crash has cut off. Blocking, at start-up. */
void job_store_resume_removals(struct job_store *s);
