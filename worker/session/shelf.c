#include "worker/session/shelf.h"

#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct shelf_entry {
    struct shelf_blob blob; /* first: what callers hold */
    struct pool_task task;
    struct shelf *shelf;
    struct shelf_entry *next;
    uint64_t bytes, last_use;
    bool has_task;
    /* Fetching. */
    struct cache_fetch fetch;
    uint64_t asked_bytes; /* parts up to here were asked for */
    unsigned ahead;       /* parts asked for and not yet there */
    unsigned fetches;     /* begun so far */
    /* Of the task, and its answer. */
    bool finish_fetch, use_cache;
    int error;
    struct fault fault;
    struct cache_pin pin; /* while it is mapped */
};

struct shelf {
    struct thread_pool *pool;
    const struct tracing *tracing;
    struct shelf_client client;
    char *blob_dir, *cache_dir; /* owned */
    uint64_t cache_bytes;
    unsigned threads;
    struct cache cache;
    bool cache_is_open, link_is_up;
    struct shelf_entry *entries;
    uint64_t clock, parts;
    _Atomic uint64_t steps;   /* of loading, by the pool */
    _Atomic uint32_t running; /* loads that a thread of the pool is at */
};

static void free_entry(struct shelf *shelf, struct shelf_entry *e)
{
    if (e->blob.loaded) shelf->tracing->unload(shelf->tracing->ctx, &e->blob.loaded);
    cache_unpin(&e->pin);
    cache_fetch_abort(&e->fetch);
    free(e);
}

static char *copy(const char *text)
{
    return text ? strdup(text) : NULL;
}

int shelf_create(struct thread_pool *pool, const struct tracing *tracing,
                 const struct shelf_options *options, const struct shelf_client *client,
                 struct shelf **out)
{
    struct shelf *shelf = calloc(1, sizeof *shelf);
    if (!shelf) return ERR_MEMORY;
    shelf->pool = pool;
    shelf->tracing = tracing;
    shelf->client = *client;
    shelf->blob_dir = copy(options->blob_dir);
    shelf->cache_dir = copy(options->cache_dir);
    shelf->cache_bytes = options->cache_bytes;
    shelf->threads = options->threads;
    if (!shelf->cache_dir || (options->blob_dir && !shelf->blob_dir)) {
        shelf_destroy(&shelf);
        return ERR_MEMORY;
    }
    *out = shelf;
    return 0;
}

void shelf_destroy(struct shelf **shelf)
{
    struct shelf *s = *shelf;
    *shelf = NULL;
    if (!s) return;
    while (s->entries) {
        struct shelf_entry *e = s->entries;
        s->entries = e->next;
        free_entry(s, e);
    }
    free(s->blob_dir);
    free(s->cache_dir);
    free(s);
}

static struct shelf_entry *find(const struct shelf *shelf, const struct digest *digest)
{
    for (struct shelf_entry *e = shelf->entries; e; e = e->next)
        if (digest_equal(&e->blob.digest, digest)) return e;
    return NULL;
}

static void drop_entry(struct shelf *shelf, struct shelf_entry *e)
{
    struct shelf_entry **at = &shelf->entries;
    while (*at != e) at = &(*at)->next;
    *at = e->next;
    free_entry(shelf, e);
}

/* ---- memory ---- */

static bool is_idle(const struct shelf_entry *e)
{
    return e->blob.refs == 0 && !e->has_task;
}

/* The least recently used idle blob; counts all of them. */
static struct shelf_entry *oldest_idle(const struct shelf *shelf, unsigned *count, uint64_t *bytes)
{
    struct shelf_entry *oldest = NULL;
    *count = 0;
    *bytes = 0;
    for (struct shelf_entry *e = shelf->entries; e; e = e->next) {
        if (!is_idle(e)) continue;
        (*count)++;
        *bytes += e->bytes;
        if (!oldest || e->last_use < oldest->last_use) oldest = e;
    }
    return oldest;
}

static void trim(struct shelf *shelf)
{
    for (struct shelf_entry *e = shelf->entries, *next; e; e = next) {
        next = e->next;
        if (is_idle(e) && e->blob.state != SHELF_READY) drop_entry(shelf, e);
    }
    for (;;) {
        unsigned count;
        uint64_t bytes;
        struct shelf_entry *e = oldest_idle(shelf, &count, &bytes);
        if (!e || (count <= SHELF_IDLE_BLOBS && bytes <= SHELF_IDLE_BYTES)) return;
        drop_entry(shelf, e);
    }
}

/* ---- on the pool: from a file to what can be traced ---- */

static int load_path(struct shelf_entry *e, const char *path)
{
    struct shelf *shelf = e->shelf;
    return shelf->tracing->load(shelf->tracing->ctx, path, shelf->threads, &shelf->steps,
                                &e->blob.loaded, &e->blob.kind, &e->bytes, &e->blob.cpu_us,
                                &e->fault);
}

static int load_from_blobs(struct shelf_entry *e)
{
    char path[CACHE_PATH_BYTES], hex[DIGEST_HEX_BYTES];
    if (!e->shelf->blob_dir) return ERR_NOT_FOUND;
    digest_to_hex(&e->blob.digest, hex);
    int n = snprintf(path, sizeof path, "%s/%.2s/%s", e->shelf->blob_dir, hex, hex + 2);
    if (n < 0 || (size_t)n >= sizeof path || access(path, R_OK) != 0) return ERR_NOT_FOUND;
    return load_path(e, path);
}

static int load_from_cache(struct shelf_entry *e)
{
    char path[CACHE_PATH_BYTES];
    if (!e->use_cache) return ERR_NOT_FOUND;
    int error = cache_pin(&e->shelf->cache, &e->blob.digest, &e->pin, path);
    if (error) return error;
    error = load_path(e, path);
    if (error) cache_unpin(&e->pin);
    return error;
}

static struct shelf_entry *entry_of(struct pool_task *task)
{
    return (struct shelf_entry *)((char *)task - offsetof(struct shelf_entry, task));
}

static int find_and_load(struct shelf_entry *e)
{
    int error = 0;
    if (e->finish_fetch) error = cache_fetch_finish(&e->shelf->cache, &e->fetch, &e->fault);
    if (error) return error;
    error = e->finish_fetch ? ERR_NOT_FOUND : load_from_blobs(e);
    return error == ERR_NOT_FOUND ? load_from_cache(e) : error;
}

static void run_load(struct pool_task *task)
{
    struct shelf_entry *e = entry_of(task);
    atomic_fetch_add(&e->shelf->steps, 1);
    atomic_fetch_add(&e->shelf->running, 1);
    e->error = find_and_load(e);
    atomic_fetch_sub(&e->shelf->running, 1);
}

/* ---- on the loop ---- */

static void settle(struct shelf_entry *e, enum shelf_state state)
{
    e->blob.state = state;
    e->blob.refs++; /* the client may release its own from inside */
    e->shelf->client.settled(e->shelf->client.ctx, &e->blob);
    e->blob.refs--;
    trim(e->shelf);
}

static void fail(struct shelf_entry *e, const struct fault *fault)
{
    cache_fetch_abort(&e->fetch);
    e->blob.fault = *fault;
    settle(e, SHELF_FAILED);
}

static void ask_more(struct shelf_entry *e)
{
    struct shelf *shelf = e->shelf;
    /* Until the first part tells the size, one at a time. */
    unsigned most = e->fetch.total_bytes ? SHELF_PARTS_AHEAD : 1;
    while (shelf->link_is_up && e->ahead < most &&
           (e->fetch.total_bytes == 0 || e->asked_bytes < e->fetch.total_bytes)) {
        struct message_blob_get get = {.digest = e->blob.digest,
                                       .offset = e->asked_bytes,
                                       .size_bytes = LIMIT_BLOB_PART_BYTES};
        e->ahead++;
        e->asked_bytes += LIMIT_BLOB_PART_BYTES;
        shelf->client.ask(shelf->client.ctx, &get);
    }
}

static void start_task(struct shelf_entry *e);

static int open_cache(struct shelf *shelf, struct fault *fault)
{
    if (shelf->cache_is_open) return 0;
    int error = cache_open(&shelf->cache, shelf->cache_dir, shelf->cache_bytes, fault);
    shelf->cache_is_open = error == 0;
    return error;
}

static void begin_fetch(struct shelf_entry *e)
{
    struct fault fault = {0};
    e->fetches++;
    if (open_cache(e->shelf, &fault) != 0 ||
        cache_fetch_begin(&e->shelf->cache, &e->blob.digest, &e->fetch, &fault) != 0) {
        fail(e, &fault);
        return;
    }
    e->fetch.steps = &e->shelf->steps;
    /* The last part that was kept may be the blob's last: ask for one byte less, so that there is
     * an answer that tells the size. */
    if (e->fetch.have_bytes > 0) e->fetch.have_bytes--;
    e->blob.state = SHELF_FETCHING;
    e->asked_bytes = e->fetch.have_bytes;
    e->ahead = 0;
    ask_more(e);
}

static void done_load(struct pool_task *task)
{
    struct shelf_entry *e = entry_of(task);
    e->has_task = false;
    bool fetch = e->error == ERR_NOT_FOUND && !e->finish_fetch;
    bool again = e->finish_fetch && (e->error == ERR_CHECKSUM || e->error == ERR_NOT_FOUND) &&
                 e->fetches < 2;
    if (e->error == 0) {
        settle(e, SHELF_READY);
    } else if (fetch && !e->use_cache && open_cache(e->shelf, &e->fault) == 0) {
        start_task(e); /* it may be in the cache from an earlier time */
    } else if (fetch || again) {
        begin_fetch(e);
    } else {
        if (e->fault.code == 0) fault_set(&e->fault, e->error, "", "%s", error_text(e->error));
        fail(e, &e->fault);
    }
}

static void start_task(struct shelf_entry *e)
{
    e->task = (struct pool_task){.run = run_load, .done = done_load};
    e->has_task = true;
    e->use_cache = e->shelf->cache_is_open;
    thread_pool_submit_first(e->shelf->pool, &e->task);
}

struct shelf_blob *shelf_take(struct shelf *shelf, const struct digest *digest)
{
    struct fault ignored;
    struct shelf_entry *e = find(shelf, digest);
    if (e && e->blob.state == SHELF_FAILED && e->blob.refs == 0) {
        drop_entry(shelf, e);
        e = NULL;
    }
    if (!e) {
        e = calloc(1, sizeof *e);
        if (!e) return NULL;
        e->blob.digest = *digest;
        e->shelf = shelf;
        e->fetch.fd = e->pin.fd = -1;
        e->next = shelf->entries;
        shelf->entries = e;
        if (!shelf->blob_dir) open_cache(shelf, &ignored);
        start_task(e);
    }
    e->blob.refs++;
    e->last_use = ++shelf->clock;
    return &e->blob;
}

void shelf_release(struct shelf *shelf, struct shelf_blob *blob)
{
    blob->refs--;
    trim(shelf);
}

void shelf_part(struct shelf *shelf, const struct message_blob_part *part)
{
    struct fault fault = {0};
    struct shelf_entry *e = find(shelf, &part->digest);
    if (!e || e->blob.state != SHELF_FETCHING) return;
    shelf->parts++;
    if (e->ahead > 0) e->ahead--;
    if (cache_fetch_part(&shelf->cache, &e->fetch, part->total_bytes, part->offset, part->bytes,
                         part->size_bytes, &fault) != 0) {
        fail(e, &fault);
        return;
    }
    if (!cache_fetch_is_whole(&e->fetch)) {
        ask_more(e);
        return;
    }
    e->blob.state = SHELF_LOADING;
    e->finish_fetch = true;
    start_task(e);
}

void shelf_none(struct shelf *shelf, const struct digest *digest)
{
    struct fault fault;
    struct shelf_entry *e = find(shelf, digest);
    if (!e || e->blob.state != SHELF_FETCHING) return;
    fault_set(&fault, ERR_NOT_FOUND, "", "the coordinator does not have the blob");
    fail(e, &fault);
}

void shelf_link_up(struct shelf *shelf)
{
    shelf->link_is_up = true;
    for (struct shelf_entry *e = shelf->entries; e; e = e->next)
        if (e->blob.state == SHELF_FETCHING) ask_more(e);
}

void shelf_link_down(struct shelf *shelf)
{
    shelf->link_is_up = false;
    for (struct shelf_entry *e = shelf->entries; e; e = e->next) {
        e->ahead = 0;
        e->asked_bytes = e->fetch.have_bytes;
    }
    trim(shelf);
}

bool shelf_is_loading(const struct shelf *shelf)
{
    for (const struct shelf_entry *e = shelf->entries; e; e = e->next)
        if (e->has_task) return true;
    return false;
}

bool shelf_is_busy(const struct shelf *shelf)
{
    for (const struct shelf_entry *e = shelf->entries; e; e = e->next)
        if (e->blob.state == SHELF_FETCHING) return true;
    return shelf_is_loading(shelf);
}

bool shelf_runs_loads(const struct shelf *shelf)
{
    return atomic_load_explicit(&shelf->running, memory_order_relaxed) > 0;
}

uint64_t shelf_steps(const struct shelf *shelf)
{
    return shelf->parts + atomic_load_explicit(&shelf->steps, memory_order_relaxed);
}
