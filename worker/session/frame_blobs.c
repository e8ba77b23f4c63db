#include "worker/session/frame_blobs.h"

#include <stddef.h>

bool frame_blobs_take(struct frame_blobs *b, struct blob_cache *cache, const struct plan *plan)
{
    const bool has_map = plan->environment.kind == ENVIRONMENT_MAP;
    if (!b->scene) b->scene = blob_cache_take(cache, &plan->scene);
    if (!b->environment && has_map) b->environment = blob_cache_take(cache, &plan->environment.map);
    return b->scene && (b->environment || !has_map);
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
}

static enum blob_state state_of(const struct cached_blob *blob, enum tracing_kind kind,
                                struct fault *fault)
{
    const bool is_scene = kind == TRACING_SCENE;
    const char *const name = is_scene ? "scene" : "environment";
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
    const enum blob_state scene = state_of(b->scene, TRACING_SCENE, fault);
    if (!b->environment || scene == BLOB_FAILED) return scene;
    const enum blob_state environment = state_of(b->environment, TRACING_ENVIRONMENT, fault);
    return environment == BLOB_READY ? scene : environment;
}

void frame_blobs_loaded(const struct frame_blobs *b, const void **scene, const void **environment)
{
    *scene = b->scene->loaded;
    *environment = b->environment ? b->environment->loaded : NULL;
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
}
