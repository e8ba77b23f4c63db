#include "worker/session/blob_cache.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "worker/session/blob_entry.h"

static void free_entry(struct blob_cache *cache, struct blob_entry *e)
{
    if (e->blob.loaded) cache->tracing->unload(cache->tracing->ctx, &e->blob.loaded);
    if (e->base) e->base->blob.refs--; /* after what stands on it */
    blob_files_unpin(&e->pin);
    blob_fetch_abort(&e->fetch);
    free(e);
}

static char *copy(const char *text)
{
    return text ? strdup(text) : NULL;
}

int blob_cache_create(struct thread_pool *pool, const struct tracing *tracing,
                      const struct blob_cache_options *options,
                      const struct blob_cache_client *client, struct blob_cache **out)
{
    struct blob_cache *cache = calloc(1, sizeof *cache);
    if (!cache) return ERR_MEMORY;
    cache->pool = pool;
    cache->tracing = tracing;
    cache->client = *client;
    cache->blob_dir = copy(options->blob_dir);
    cache->cache_dir = copy(options->cache_dir);
    cache->cache_bytes = options->cache_bytes;
    cache->threads = options->threads;
    if (!cache->cache_dir || (options->blob_dir && !cache->blob_dir)) {
        blob_cache_destroy(&cache);
        return ERR_MEMORY;
    }
    *out = cache;
    return 0;
}

static void drop_entry(struct blob_cache *cache, struct blob_entry *e)
{
    struct blob_entry **at = &cache->entries;
    while (*at != e) at = &(*at)->next;
    *at = e->next;
    free_entry(cache, e);
}

/* Frames go before their base. */
static struct blob_entry *first_to_drop(const struct blob_cache *cache)
{
    for (struct blob_entry *e = cache->entries; e; e = e->next)
        if (e->base) return e;
    return cache->entries;
}

void blob_cache_destroy(struct blob_cache **cache)
{
    struct blob_cache *s = *cache;
    *cache = NULL;
    if (!s) return;
    while (s->entries) drop_entry(s, first_to_drop(s));
    free(s->blob_dir);
    free(s->cache_dir);
    free(s);
}

static struct blob_entry *find(const struct blob_cache *cache, const struct digest *digest)
{
    for (struct blob_entry *e = cache->entries; e; e = e->next)
        if (digest_equal(&e->blob.digest, digest)) return e;
    return NULL;
}

/* ---- memory ---- */

static bool is_idle(const struct blob_entry *e)
{
    return e->blob.refs == 0 && !e->has_task;
}

/* Returns the least recently used idle blob; counts all of them. */
static struct blob_entry *oldest_idle(const struct blob_cache *cache, unsigned *count,
                                      uint64_t *bytes)
{
    struct blob_entry *oldest = NULL;
    *count = 0;
    *bytes = 0;
    for (struct blob_entry *e = cache->entries; e; e = e->next) {
        if (!is_idle(e)) continue;
        (*count)++;
        *bytes += e->bytes;
        if (!oldest || e->last_use < oldest->last_use) oldest = e;
    }
    return oldest;
}

static void trim(struct blob_cache *cache)
{
    for (struct blob_entry *e = cache->entries, *next; e; e = next) {
        next = e->next;
        if (is_idle(e) && e->blob.state != BLOB_READY) drop_entry(cache, e);
    }
    for (;;) {
        unsigned count;
        uint64_t bytes;
        struct blob_entry *e = oldest_idle(cache, &count, &bytes);
        if (!e || (count <= BLOB_CACHE_IDLE_BLOBS && bytes <= BLOB_CACHE_IDLE_BYTES)) return;
        drop_entry(cache, e);
    }
}

/* ---- on the loop ---- */

static void wake_frames(struct blob_entry *base);

static void settle(struct blob_entry *e, enum blob_state state)
{
    e->blob.state = state;
    e->blob.refs++; /* the client may release its own from inside */
    e->cache->client.settled(e->cache->client.ctx, &e->blob);
    wake_frames(e);
    e->blob.refs--;
    trim(e->cache);
}

static void fail(struct blob_entry *e, const struct fault *fault)
{
    blob_fetch_abort(&e->fetch);
    e->blob.fault = *fault;
    settle(e, BLOB_FAILED);
}

static void ask_more(struct blob_entry *e)
{
    struct blob_cache *cache = e->cache;
    /* Until the first part tells the size, one at a time. */
    unsigned most = e->fetch.total_bytes ? BLOB_CACHE_PARTS_AHEAD : 1;
    while (cache->link_is_up && e->ahead < most &&
           (e->fetch.total_bytes == 0 || e->asked_bytes < e->fetch.total_bytes)) {
        struct message_blob_get get = {.digest = e->blob.digest,
                                       .offset = e->asked_bytes,
                                       .size_bytes = LIMIT_BLOB_PART_BYTES};
        e->ahead++;
        e->asked_bytes += LIMIT_BLOB_PART_BYTES;
        cache->client.ask(cache->client.ctx, &get);
    }
}

static void start_task(struct blob_entry *e);

static int open_files(struct blob_cache *cache, struct fault *fault)
{
    if (cache->files_are_open) return 0;
    int error = blob_files_open(&cache->files, cache->cache_dir, cache->cache_bytes, fault);
    cache->files_are_open = error == 0;
    return error;
}

static void begin_fetch(struct blob_entry *e)
{
    struct fault fault = {0};
    e->fetches++;
    if (open_files(e->cache, &fault) != 0 ||
        blob_fetch_begin(&e->cache->files, &e->blob.digest, &e->fetch, &fault) != 0) {
        fail(e, &fault);
        return;
    }
    e->fetch.steps = &e->cache->steps;
    /* The last part that was kept may be the blob's last: ask for one byte less, so that there is
     * an answer that tells the size. */
    if (e->fetch.have_bytes > 0) e->fetch.have_bytes--;
    e->blob.state = BLOB_FETCHING;
    e->asked_bytes = e->fetch.have_bytes;
    e->ahead = 0;
    ask_more(e);
}

/* Loads a frame's blob again, now that its base is there, or has failed. */
static void load_on_base(struct blob_entry *e)
{
    struct fault fault;
    const struct cached_blob *base = &e->base->blob;
    if (base->state == BLOB_FAILED) {
        fault_set(&fault, base->fault.code, "base", "%s%s%s", base->fault.pointer,
                  base->fault.pointer[0] ? ": " : "", base->fault.detail);
        fail(e, &fault);
    } else if (base->kind != TRACING_BASE) {
        fault_set(&fault, ERR_MISMATCH, "base", "the blob that it stands on is no base of frames");
        fail(e, &fault);
    } else {
        e->base_loaded = base->loaded;
        start_task(e);
    }
}

static bool is_settled(const struct blob_entry *e)
{
    return e->blob.state == BLOB_READY || e->blob.state == BLOB_FAILED;
}

/* Goes on with frames that waited for a base. Each may change the list, so the walk begins anew. */
static void wake_frames(struct blob_entry *base)
{
    struct blob_entry *e = base->cache->entries;
    while (e) {
        const bool waits = e->base == base && !e->has_task && !is_settled(e) && !e->base_loaded;
        if (waits) load_on_base(e);
        e = waits ? base->cache->entries : e->next;
    }
}

/* Takes the base of a frame's blob, and waits for it. */
static void await_base(struct blob_entry *e)
{
    struct fault fault;
    struct cached_blob *base = blob_cache_take(e->cache, &e->base_digest);
    if (!base) {
        fault_set(&fault, ERR_MEMORY, "base", "no memory for the blob that it stands on");
        fail(e, &fault);
        return;
    }
    e->base = (struct blob_entry *)base; /* blob is its first member */
    e->finish_fetch = false;             /* it is among the files now */
    e->blob.state = BLOB_LOADING;
    if (is_settled(e->base)) load_on_base(e);
}

/* What loading the base took is counted with the first frame. */
static void take_costs(struct blob_entry *e)
{
    if (!e->base) return;
    if (e->base->blob.cpu_us > 0) e->blob.reused_triangles = 0; /* it was built for this one */
    e->blob.cpu_us += e->base->blob.cpu_us;
    e->base->blob.cpu_us = 0;
}

static void done_load(struct pool_task *task)
{
    struct blob_entry *e = blob_entry_of(task);
    e->has_task = false;
    bool fetch = e->error == ERR_NOT_FOUND && !e->finish_fetch;
    bool again = e->finish_fetch && (e->error == ERR_CHECKSUM || e->error == ERR_NOT_FOUND) &&
                 e->fetches < 2;
    if (e->error == 0) {
        take_costs(e);
        settle(e, BLOB_READY);
    } else if (e->error == ERR_INCOMPLETE && !e->base) {
        await_base(e);
    } else if (fetch && !e->use_files && open_files(e->cache, &e->fault) == 0) {
        start_task(e); /* it may be in the cache from an earlier time */
    } else if (fetch || again) {
        begin_fetch(e);
    } else {
        if (e->fault.code == 0) fault_set(&e->fault, e->error, "", "%s", error_text(e->error));
        fail(e, &e->fault);
    }
}

static void start_task(struct blob_entry *e)
{
    e->task = (struct pool_task){.run = blob_load_run, .done = done_load};
    e->has_task = true;
    e->use_files = e->cache->files_are_open;
    thread_pool_submit_first(e->cache->pool, &e->task);
}

struct cached_blob *blob_cache_take(struct blob_cache *cache, const struct digest *digest)
{
    struct fault ignored;
    struct blob_entry *e = find(cache, digest);
    if (e && e->blob.state == BLOB_FAILED && e->blob.refs == 0) {
        drop_entry(cache, e);
        e = NULL;
    }
    if (!e) {
        e = calloc(1, sizeof *e);
        if (!e) return NULL;
        e->blob.digest = *digest;
        e->cache = cache;
        e->fetch.fd = e->pin.fd = -1;
        e->next = cache->entries;
        cache->entries = e;
        if (!cache->blob_dir) open_files(cache, &ignored);
        start_task(e);
    }
    e->blob.refs++;
    e->last_use = ++cache->clock;
    return &e->blob;
}

void blob_cache_release(struct blob_cache *cache, struct cached_blob *blob)
{
    blob->refs--;
    trim(cache);
}

void blob_cache_part(struct blob_cache *cache, const struct message_blob_part *part)
{
    struct fault fault = {0};
    struct blob_entry *e = find(cache, &part->digest);
    if (!e || e->blob.state != BLOB_FETCHING) return;
    cache->parts++;
    if (e->ahead > 0) e->ahead--;
    if (blob_fetch_part(&cache->files, &e->fetch, part->total_bytes, part->offset, part->bytes,
                        part->size_bytes, &fault) != 0) {
        fail(e, &fault);
        return;
    }
    if (!blob_fetch_is_whole(&e->fetch)) {
        ask_more(e);
        return;
    }
    e->blob.state = BLOB_LOADING;
    e->finish_fetch = true;
    start_task(e);
}

void blob_cache_none(struct blob_cache *cache, const struct digest *digest)
{
    struct fault fault;
    struct blob_entry *e = find(cache, digest);
    if (!e || e->blob.state != BLOB_FETCHING) return;
    fault_set(&fault, ERR_NOT_FOUND, "", "the coordinator does not have the blob");
    fail(e, &fault);
}

void blob_cache_link_up(struct blob_cache *cache)
{
    cache->link_is_up = true;
    for (struct blob_entry *e = cache->entries; e; e = e->next)
        if (e->blob.state == BLOB_FETCHING) ask_more(e);
}

void blob_cache_link_down(struct blob_cache *cache)
{
    cache->link_is_up = false;
    for (struct blob_entry *e = cache->entries; e; e = e->next) {
        e->ahead = 0;
        e->asked_bytes = e->fetch.have_bytes;
    }
    trim(cache);
}

bool blob_cache_is_loading(const struct blob_cache *cache)
{
    for (const struct blob_entry *e = cache->entries; e; e = e->next)
        if (e->has_task) return true;
    return false;
}

bool blob_cache_is_busy(const struct blob_cache *cache)
{
    for (const struct blob_entry *e = cache->entries; e; e = e->next)
        if (e->blob.state == BLOB_FETCHING) return true;
    return blob_cache_is_loading(cache);
}

bool blob_cache_runs_loads(const struct blob_cache *cache)
{
    return atomic_load_explicit(&cache->running, memory_order_relaxed) > 0;
}

uint64_t blob_cache_steps(const struct blob_cache *cache)
{
    return cache->parts + atomic_load_explicit(&cache->steps, memory_order_relaxed);
}
