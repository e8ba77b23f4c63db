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
#include "worker/session/cache.h"
#include "worker/session/tracing.h"

#define SHELF_IDLE_BLOBS  6u           /* kept without a reference */
#define SHELF_IDLE_BYTES  (2ull << 30) /* and the memory that they may hold */
#define SHELF_PARTS_AHEAD 4u           /* blob parts asked for at a time */

enum shelf_state { SHELF_LOOKING, SHELF_FETCHING, SHELF_LOADING, SHELF_READY, SHELF_FAILED };

struct shelf_blob {
    struct digest digest;
    enum shelf_state state;
    void *loaded;           /* READY: for tracing->trace */
    enum tracing_kind kind; /* READY */
    struct fault fault;     /* FAILED: why */
    uint64_t cpu_us;        /* READY: what loading cost; taken by who counts it */
    unsigned refs;
};

struct shelf;

struct shelf_client {
    void *ctx;
    void (*ask)(void *ctx, const struct message_blob_get *part); /* send it, if there is a link */
    void (*settled)(void *ctx, struct shelf_blob *blob);         /* READY or FAILED */
};

struct shelf_options {
    const char *blob_dir;  /* may be NULL */
    const char *cache_dir; /* made when the first blob is fetched */
    uint64_t cache_bytes;
    unsigned threads; /* for building a BVH */
};

int shelf_create(struct thread_pool *pool, const struct tracing *tracing,
                 const struct shelf_options *options, const struct shelf_client *client,
                 struct shelf **out);

/* After the pool was closed. Nulls the pointer. */
void shelf_destroy(struct shelf **shelf);

/* A reference to a blob in any state; `settled` comes later unless it is READY already. NULL: out
 * of memory. */
struct shelf_blob *shelf_take(struct shelf *shelf, const struct digest *digest);
void shelf_release(struct shelf *shelf, struct shelf_blob *blob);

/* What the coordinator answered. A part or a digest that nobody waits for is ignored. */
void shelf_part(struct shelf *shelf, const struct message_blob_part *part);
void shelf_none(struct shelf *shelf, const struct digest *digest);

/* The link is there (again): asks for what is missing. Or it is gone: answers will not come. */
void shelf_link_up(struct shelf *shelf);
void shelf_link_down(struct shelf *shelf);

/* Blobs that are fetched or loaded at the moment, or wait for a thread to load them; whether a
 * thread is at one; steps of all that so far. */
bool shelf_is_busy(const struct shelf *shelf);
bool shelf_is_loading(const struct shelf *shelf);
bool shelf_runs_loads(const struct shelf *shelf);
uint64_t shelf_steps(const struct shelf *shelf);
