#pragma once
/* The blobs that a frame's tiles are traced with: its scene, and its environment map and its
 * photograph if the plan has them. They are references into the blob cache, held while tiles are
 * open. */
#include "proto/plan.h"
#include "worker/session/blob_cache.h"

struct frame_blobs {
    struct cached_blob *scene;       /* NULL: not held */
    struct cached_blob *environment; /* NULL: not held, or the plan has none */
    struct cached_blob *photograph;  /* the same */
};

/* Takes the references that are not held yet. False: out of memory. */
bool frame_blobs_take(struct frame_blobs *b, struct blob_cache *cache, const struct plan *plan);
void frame_blobs_release(struct frame_blobs *b, struct blob_cache *cache);

/* Returns READY when all blobs are loaded and of the right kind, and FAILED, with *fault, as soon
 * as one is not. In any other state the tiles have to wait. */
enum blob_state frame_blobs_state(const struct frame_blobs *b, struct fault *fault);

/* Returns whether the blob is one of them. */
bool frame_blobs_have(const struct frame_blobs *b, const struct cached_blob *blob);

/* Points the job to the loaded blobs. The state must be READY. */
void frame_blobs_loaded(const struct frame_blobs *b, struct tracing_job *job);

/* Counts what loading took, once: later calls count nothing. */
void frame_blobs_take_costs(struct frame_blobs *b, struct counters *counters);
