#pragma once
/* What a cache of blobs keeps of each, and the loading that the pool does for it. */
#include <stddef.h>

#include "worker/session/blob_cache.h"

struct blob_entry {
    struct cached_blob blob; /* first: what callers hold */
    struct pool_task task;
    struct blob_cache *cache;
    struct blob_entry *next;
    uint64_t bytes, last_use;
    bool has_task;
    /* Fetching. */
    struct blob_fetch fetch;
    uint64_t asked_bytes; /* parts up to here were asked for */
    unsigned ahead;       /* parts asked for and not yet there */
    unsigned fetches;     /* begun so far */
    /* Of the task, and its answer. */
    bool finish_fetch, use_files;
    struct blob_entry *base; /* held; NULL: none is known of */
    struct digest base_digest;
    const void *base_loaded; /* for the task; NULL: it is not there yet */
    int error;
    struct fault fault;
    struct blob_pin pin; /* while it is mapped */
};

struct blob_cache {
    struct thread_pool *pool;
    const struct tracing *tracing;
    struct blob_cache_client client;
    char *blob_dir, *cache_dir; /* owned */
    uint64_t cache_bytes;
    unsigned threads;
    struct blob_files files;
    bool files_are_open, link_is_up;
    struct blob_entry *entries;
    uint64_t clock, parts;
    _Atomic uint64_t steps;   /* of loading, by the pool */
    _Atomic uint32_t running; /* loads that a thread of the pool is at */
};

static inline struct blob_entry *blob_entry_of(struct pool_task *task)
{
    return (struct blob_entry *)((char *)task - offsetof(struct blob_entry, task));
}

/* Runs on the pool: finishes the fetch, finds the blob's file and makes of it what can be traced.
 * The entry's `error` and `fault` answer. */
void blob_load_run(struct pool_task *task);
