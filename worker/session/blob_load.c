#include <stdatomic.h>
#include <stdio.h>
#include <unistd.h>

#include "worker/session/blob_entry.h"

/* ERR_INCOMPLETE for a blob whose base is to be loaded first. */
static int load_path(struct blob_entry *e, const char *path)
{
    struct blob_cache *cache = e->cache;
    const struct tracing *tracing = cache->tracing;
    struct tracing_cost cost = {0};
    int error = 0;
    if (!e->base_loaded && tracing->find_base)
        error = tracing->find_base(tracing->ctx, path, &e->base_digest);
    if (!error && !e->base_loaded && !digest_is_zero(&e->base_digest)) return ERR_INCOMPLETE;
    error = tracing->load(tracing->ctx, path, e->base_loaded, cache->threads, &cache->steps,
                          &e->blob.loaded, &e->blob.kind, &cost, &e->fault);
    e->bytes = cost.bytes;
    e->blob.cpu_us = cost.cpu_us;
    e->blob.reused_triangles = cost.reused_triangles;
    return error;
}

static int load_from_blobs(struct blob_entry *e)
{
    char path[BLOB_FILES_PATH_BYTES], hex[DIGEST_HEX_BYTES];
    if (!e->cache->blob_dir) return ERR_NOT_FOUND;
    digest_to_hex(&e->blob.digest, hex);
    int n = snprintf(path, sizeof path, "%s/%.2s/%s", e->cache->blob_dir, hex, hex + 2);
    if (n < 0 || (size_t)n >= sizeof path || access(path, R_OK) != 0) return ERR_NOT_FOUND;
    return load_path(e, path);
}

static int load_from_files(struct blob_entry *e)
{
    char path[BLOB_FILES_PATH_BYTES];
    if (!e->use_files) return ERR_NOT_FOUND;
    int error = blob_files_pin(&e->cache->files, &e->blob.digest, &e->pin, path);
    if (error) return error;
    error = load_path(e, path);
    if (error) blob_files_unpin(&e->pin);
    return error;
}

static int find_and_load(struct blob_entry *e)
{
    int error = 0;
    if (e->finish_fetch) error = blob_fetch_finish(&e->cache->files, &e->fetch, &e->fault);
    if (error) return error;
    error = e->finish_fetch ? ERR_NOT_FOUND : load_from_blobs(e);
    return error == ERR_NOT_FOUND ? load_from_files(e) : error;
}

void blob_load_run(struct pool_task *task)
{
    struct blob_entry *e = blob_entry_of(task);
    atomic_fetch_add(&e->cache->steps, 1);
    atomic_fetch_add(&e->cache->running, 1);
    e->error = find_and_load(e);
    atomic_fetch_sub(&e->cache->running, 1);
}
