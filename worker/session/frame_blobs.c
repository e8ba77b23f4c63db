#include "worker/session/frame_blobs.h"

#include <stddef.h>

bool frame_blobs_take(struct frame_blobs *b, struct blob_cache *cache, const struct plan *plan)
{
    const bool has_map = plan->environment.kind == ENVIRONMENT_MAP;
    const bool has_photograph = plan->photograph.fit != PHOTOGRAPH_NONE;
    if (!b->scene) b->scene = blob_cache_take(cache, &plan->scene);
    if (!b->environment && has_map) b->environment = blob_cache_take(cache, &plan->environment.map);
    if (!b->photograph && has_photograph)
        b->photograph = blob_cache_take(cache, &plan->photograph.blob);
    return b->scene && (b->environment || !has_map) && (b->photograph || !has_photograph);
}

static void release(struct cached_blob **blob, struct blob_cache *cache)
{
    struct cached_blob *held = *blob;
    *blob = NULL;
    if (held) blob_cache_release(cache, held);
}

void frame_blobs_release(struct frame_blobs *b, struct blob_cache *cache)
{
    release(&b->scene, cache);
    release(&b->environment, cache);
    release(&b->photograph, cache);
}

static enum blob_state state_of(const struct cached_blob *blob, enum tracing_kind kind,
                                const char *name, struct fault *fault)
{
    if (!blob) return BLOB_READY;
    if (blob->state == BLOB_FAILED) {
        const struct fault *why = &blob->fault;
        fault_set(fault, why->code, name, "%s%s%s", why->pointer, why->pointer[0] ? ": " : "",
                  why->detail);
    } else if (blob->state == BLOB_READY && blob->kind != kind) {
        fault_set(fault, ERR_MAGIC, name,
                  blob->kind == TRACING_ENVIRONMENT ? "this is an environment map"
                  : blob->kind == TRACING_BASE      ? "this is a base of frames"
                                                    : "this is a scene");
        return BLOB_FAILED;
    }
    return blob->state;
}

enum blob_state frame_blobs_state(const struct frame_blobs *b, struct fault *fault)
{
    const enum blob_state states[] = {
        state_of(b->scene, TRACING_SCENE, "scene", fault),
        state_of(b->environment, TRACING_ENVIRONMENT, "environment", fault),
        state_of(b->photograph, TRACING_ENVIRONMENT, "photograph", fault)};
    enum blob_state waits = BLOB_READY;
    for (int i = 0; i < 3; i++) {
        if (states[i] == BLOB_FAILED) return BLOB_FAILED;
        if (waits == BLOB_READY) waits = states[i];
    }
    return waits;
}

bool frame_blobs_have(const struct frame_blobs *b, const struct cached_blob *blob)
{
    return b->scene == blob || b->environment == blob || b->photograph == blob;
}

void frame_blobs_loaded(const struct frame_blobs *b, struct tracing_job *job)
{
    job->scene = b->scene->loaded;
    job->environment = b->environment ? b->environment->loaded : NULL;
    job->photograph = b->photograph ? b->photograph->loaded : NULL;
}

static void take_costs(struct cached_blob *blob, struct counters *counters)
{
    if (!blob) return;
    counters->value[COUNTER_BUILD_CPU_US] += blob->cpu_us;
    counters->value[COUNTER_SKIPPED_REBUILD] += blob->reused_triangles;
    blob->cpu_us = blob->reused_triangles = 0;
}

void frame_blobs_take_costs(struct frame_blobs *b, struct counters *counters)
{
    take_costs(b->scene, counters);
    take_costs(b->environment, counters);
    take_costs(b->photograph, counters);
}
