#pragma once
/* Blobs (scenes, environment maps) ready to trace, and how they become so: mapped from a local
 * coordinator's folder, or from the cache, or fetched into the cache part by part over the link;
 * then loaded on the pool.
 *
 * Who traces with a blob holds a reference. Blobs without references stay while they are few and
 * small: the least recently used go first. All calls on the loop's thread. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/digest.h"
#include "proto/link/message.h"
#include "proto/runtime/thread_pool.h"
#include "worker/session/blob_files.h"
#include "worker/session/tracing.h"

#define BLOB_CACHE_IDLE_BLOBS  6u           /* kept without a reference */
#define BLOB_CACHE_IDLE_BYTES  (2ull << 30) /* and the memory that they may hold */
#define BLOB_CACHE_PARTS_AHEAD 4u           /* blob parts asked for at a time */

enum blob_state { BLOB_LOOKING, BLOB_FETCHING, BLOB_LOADING, BLOB_READY, BLOB_FAILED };

struct cached_blob {
    struct digest digest;
    enum blob_state state;
    void *loaded;           /* READY: for tracing->trace */
    enum tracing_kind kind; /* READY */
    struct fault fault;     /* FAILED: why */
    uint64_t cpu_us;        /* READY: what loading cost; taken by who counts it */
    unsigned refs;
};

struct blob_cache;

struct blob_cache_client {
    void *ctx;
    void (*ask)(void *ctx, const struct message_blob_get *part); /* send it, if there is a link */
    void (*settled)(void *ctx, struct cached_blob *blob);        /* READY or FAILED */
};

struct blob_cache_options {
    const char *blob_dir;  /* may be NULL */
    const char *cache_dir; /* made when the first blob is fetched */
    uint64_t cache_bytes;
    unsigned threads; /* for building a BVH */
};

int blob_cache_create(struct thread_pool *pool, const struct tracing *tracing,
                      const struct blob_cache_options *options,
                      const struct blob_cache_client *client, struct blob_cache **out);

/* After the pool was closed. Nulls the pointer. */
void blob_cache_destroy(struct blob_cache **cache);

/* A reference to a blob in any state; `settled` comes later unless it is READY already. NULL: out
 * of memory. */
struct cached_blob *blob_cache_take(struct blob_cache *cache, const struct digest *digest);
void blob_cache_release(struct blob_cache *cache, struct cached_blob *blob);

/* What the coordinator answered. A part or a digest that nobody waits for is ignored. */
void blob_cache_part(struct blob_cache *cache, const struct message_blob_part *part);
void blob_cache_none(struct blob_cache *cache, const struct digest *digest);

/* The link is there (again): asks for what is missing. Or it is gone: answers will not come. */
void blob_cache_link_up(struct blob_cache *cache);
void blob_cache_link_down(struct blob_cache *cache);

/* Blobs that are fetched or loaded at the moment, or wait for a thread to load them; whether a
 * thread is at one; steps of all that so far. */
bool blob_cache_is_busy(const struct blob_cache *cache);
bool blob_cache_is_loading(const struct blob_cache *cache);
bool blob_cache_runs_loads(const struct blob_cache *cache);
uint64_t blob_cache_steps(const struct blob_cache *cache);
