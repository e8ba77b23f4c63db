#pragma once
/* The blobs that a frame's tiles are traced with: its scene, and its environment map if the plan
 * has one. References in the blob cache while tiles are open. */
#include "proto/plan.h"
#include "worker/session/blob_cache.h"

struct frame_blobs {
    struct cached_blob *scene;       /* NULL: not held */
    struct cached_blob *environment; /* NULL: not held, or the plan has none */
};

/* Holds what the plan names and is not held yet. False: out of memory. */
bool frame_blobs_take(struct frame_blobs *b, struct blob_cache *cache, const struct plan *plan);
void frame_blobs_release(struct frame_blobs *b, struct blob_cache *cache);

/* READY when all of them are and each is what it should be; FAILED as soon as one is not, with
 * *fault naming which; any other state: wait. */
enum blob_state frame_blobs_state(const struct frame_blobs *b, struct fault *fault);

/* READY: what tracing->trace gets; *environment is NULL when there is none. */
void frame_blobs_loaded(const struct frame_blobs *b, const void **scene, const void **environment);

/* What loading cost, told once. */
uint64_t frame_blobs_take_cpu_us(struct frame_blobs *b);
