#pragma once
/* One request to the job store on its way: from the loop's thread to the store's and back. */
#include "server/store/asset_removal.h"
#include "server/store/job_database.h"

enum request_kind {
    REQUEST_INSERT,
    REQUEST_UPDATE,
    REQUEST_STEER,
    REQUEST_MARK, /* `document` has the marks */
    REQUEST_UPDATE_FRAME,
    REQUEST_UPDATE_DOCUMENT,
    REQUEST_REMOVE,
    REQUEST_KEEP_ASSET,
    REQUEST_NOTE_REMOVAL,
    REQUEST_KEEP_THUMBNAIL,
    REQUEST_NOTE_WEBHOOK,
    REQUEST_REMEMBER_BLOB, /* the last that writes */
    REQUEST_FIND_KEY,
    REQUEST_GET,
    REQUEST_FIND_THUMBNAIL,
    REQUEST_LIST_WEBHOOKS,
    REQUEST_LIST,
    REQUEST_FIND_BLOB,
    REQUEST_FIND_ASSETS,
    REQUEST_REMOVE_ASSET,  /* after the batch's changes, in transactions of its own */
    REQUEST_PASS_REMOVALS, /* the same */
};

typedef void (*job_store_passed)(void *ctx, int error, const struct removal_pass *pass);

/* A request, and then its result. The loop's thread writes it, the store's thread adds the result,
 * and the loop's reads that; the pool's queue hands it over. Texts are owned copies, NULL where
 * absent. */
struct job_request {
    struct job_request *next;
    enum request_kind kind;
    int error;
    void *ctx;
    char id[JOB_ID_BYTES], owner[JOB_OWNER_BYTES], trace[TRACE_CONTEXT_TEXT_BYTES];
    char *state, *fault, *report, *document, *key, *cursor, *text, *name, *labels, *webhook;
    int64_t created_ms, updated_ms;
    int32_t priority;
    bool owned; /* REQUEST_LIST, REQUEST_MARK: of `owner` alone */
    uint64_t seen_revision;
    bool paused, has_priority, has_paused; /* REQUEST_STEER sets what it has */
    struct frame_row frame;                /* its state is `state` */
    struct digest body, source, blob;
    struct digest *assets; /* owned; for requests with several */
    size_t asset_count;
    size_t missing, *tell_missing; /* the first of them that is not there; NULL: not asked */
    bool gone;                     /* REQUEST_REMEMBER_BLOB: one is not, and the blob is noted */
    struct asset_room room;        /* for requests that look at stored files */
    struct asset_claim claim;      /* on one asset, or on all of `assets` */
    uint64_t size_bytes;           /* of that one */
    bool existed;                  /* REQUEST_KEEP_ASSET */
    struct removal_pass pass;      /* of REQUEST_PASS_REMOVALS: the last one, then this one */
    struct asset_users users;
    struct webhook_row *webhooks; /* owned */
    size_t webhook_count;
    uint32_t tries;
    int64_t due_ms;
    void *png; /* owned */
    size_t png_bytes;
    size_t limit;
    char existing[JOB_ID_BYTES];
    struct job_records records;
    union {
        job_store_inserted inserted;
        job_store_done done;
        job_store_found found;
        job_store_listed listed;
        job_store_blob blob;
        job_store_kept kept;
        job_store_gave_up gave_up;
        job_store_passed passed;
        job_store_pictured pictured;
        job_store_hooked hooked;
    } call;
};

/* Creates a request; NULL on failed allocation. */
struct job_request *job_request_create(enum request_kind kind, const char *id, void *ctx);
void job_request_free(struct job_request *r);

/* Copies text (NULL: none); notes a failed copy in *error. */
char *job_request_copy(const char *text, int *error);

/* Copies assets to r->assets. ERR_MEMORY. */
int job_request_take_assets(struct job_request *r, const struct digest *assets, size_t count);

/* Replaces its texts with those that a newer request of its kind has. */
void job_request_take_texts(struct job_request *r, struct job_request *newer);

/* Returns whether it changes something in the batch's transaction. */
bool job_request_is_write(const struct job_request *r);
/* Returns whether it changes something in a transaction of its own. */
bool job_request_is_lone_write(const struct job_request *r);
/* Returns whether it may have left a removal that waits, once performed. */
bool job_request_may_wait(const struct job_request *r);

/* Runs the query, on the store's thread. Returns its error. */
int job_request_perform(struct job_request *r, struct job_database *db);

/* Calls back with the result, on the loop's thread. */
void job_request_answer(const struct job_request *r);
