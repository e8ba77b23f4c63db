#pragma once
/* Loaded blobs (scenes, environment maps). A blob is mapped from a local coordinator's folder or
 * from the worker's own files (blob_files.h), or fetched into these part by part over the link.
 * Then the pool loads it. A frame of a scene that moves is loaded once its base is, and holds that.
 *
 * A frame holds a reference to each blob it is traced with. Blobs without references stay loaded
 * within the limits below; the least recently used is dropped first. All functions are for the
 * loop's thread. */
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
    uint64_t cpu_us;        /* READY: CPU time of loading, its base's, too; 0 once it is counted */
    uint64_t reused_triangles; /* READY: triangles in its base's trees; 0 once they are counted */
    unsigned refs;
};

struct blob_cache;

struct blob_cache_client {
    void *ctx;
    void (*ask)(void *ctx, const struct message_blob_get *part); /* sent if there is a link */
    void (*settled)(void *ctx, struct cached_blob *blob);        /* READY or FAILED */
};

struct blob_cache_options {
    const char *blob_dir;  /* may be NULL */
    const char *cache_dir; /* is created when the first blob is fetched */
    uint64_t cache_bytes;
    unsigned threads; /* for building a BVH */
};

int blob_cache_create(struct thread_pool *pool, const struct tracing *tracing,
                      const struct blob_cache_options *options,
                      const struct blob_cache_client *client, struct blob_cache **out);

/* Unloads all blobs. The pool must be closed. Nulls the pointer. */
void blob_cache_destroy(struct blob_cache **cache);

/* Takes a reference to a blob in any state. `settled` is called later unless the blob is READY
 * already. NULL: out of memory. */
struct cached_blob *blob_cache_take(struct blob_cache *cache, const struct digest *digest);
void blob_cache_release(struct blob_cache *cache, struct cached_blob *blob);

/* Take the coordinator's answers to BLOB_GET. A part or digest that was not asked for is ignored.
 */
void blob_cache_part(struct blob_cache *cache, const struct message_blob_part *part);
void blob_cache_none(struct blob_cache *cache, const struct digest *digest);

/* Asks for the missing parts when the link is up; forgets the open questions when it is lost. */
void blob_cache_link_up(struct blob_cache *cache);
void blob_cache_link_down(struct blob_cache *cache);

/* Returns whether a blob is being fetched, loaded or queued for loading; whether one is loaded
 * or queued; whether a thread is loading one; and the number of steps that fetching and loading
 * have made. */
bool blob_cache_is_busy(const struct blob_cache *cache);
bool blob_cache_is_loading(const struct blob_cache *cache);
bool blob_cache_runs_loads(const struct blob_cache *cache);
uint64_t blob_cache_steps(const struct blob_cache *cache);
