#include "worker/session/frame_blobs.h"

#include <stddef.h>

bool frame_blobs_take(struct frame_blobs *b, struct shelf *shelf, const struct plan *plan)
{
    const bool has_map = plan->environment.kind == ENVIRONMENT_MAP;
    if (!b->scene) b->scene = shelf_take(shelf, &plan->scene);
    if (!b->environment && has_map) b->environment = shelf_take(shelf, &plan->environment.map);
    return b->scene && (b->environment || !has_map);
}

static void release(struct shelf_blob **blob, struct shelf *shelf)
{
    struct shelf_blob *held = *blob;
    *blob = NULL;
    if (held) shelf_release(shelf, held);
}

void frame_blobs_release(struct frame_blobs *b, struct shelf *shelf)
{
    release(&b->scene, shelf);
    release(&b->environment, shelf);
}

static enum shelf_state state_of(const struct shelf_blob *blob, enum tracing_kind kind,
                                 struct fault *fault)
{
    const bool is_scene = kind == TRACING_SCENE;
    const char *const name = is_scene ? "scene" : "environment";
    if (blob->state == SHELF_FAILED) {
        const struct fault *why = &blob->fault;
        fault_set(fault, why->code, name, "%s%s%s", why->pointer, why->pointer[0] ? ": " : "",
                  why->detail);
    } else if (blob->state == SHELF_READY && blob->kind != kind) {
        fault_set(fault, ERR_MAGIC, name,
                  is_scene ? "this is an environment map" : "this is a scene");
        return SHELF_FAILED;
    }
    return blob->state;
}

enum shelf_state frame_blobs_state(const struct frame_blobs *b, struct fault *fault)
{
    const enum shelf_state scene = state_of(b->scene, TRACING_SCENE, fault);
    if (!b->environment || scene == SHELF_FAILED) return scene;
    const enum shelf_state environment = state_of(b->environment, TRACING_ENVIRONMENT, fault);
    return environment == SHELF_READY ? scene : environment;
}

void frame_blobs_loaded(const struct frame_blobs *b, const void **scene, const void **environment)
{
    *scene = b->scene->loaded;
    *environment = b->environment ? b->environment->loaded : NULL;
}

static uint64_t take_cpu_us(struct shelf_blob *blob)
{
    const uint64_t cpu_us = blob ? blob->cpu_us : 0;
    if (blob) blob->cpu_us = 0;
    return cpu_us;
}

uint64_t frame_blobs_take_cpu_us(struct frame_blobs *b)
{
    return take_cpu_us(b->scene) + take_cpu_us(b->environment);
}
