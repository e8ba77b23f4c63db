#pragma once
/* One run of shearwater-import: a fenced child in a folder of its own that turns a scene's files
 * into a blob, and is killed when it takes too long. */
#include <uv.h>

#include "proto/job/job.h"
#include "proto/runtime/thread_pool.h"
#include "server/store/objects.h"

struct import_process;

struct import_options {
    uv_loop_t *loop;
    struct thread_pool *pool;      /* prepares files, hashes the blob */
    const struct objects *objects; /* where assets are and the blob goes */
    const char *program;
    uint64_t limit_ms; /* of wall time */
};

/* The most times at which one run imports a scene. */
#define IMPORT_TIMES 64u

struct import_times {
    uint32_t count; /* 0: the scene as it is at the job's time_s */
    double list[IMPORT_TIMES];
};

/* What a run made: a blob for each time as far as there are any, and what they stand on. A scene
 * that does not move has one, for all times. */
struct import_blobs {
    uint32_t count;
    struct digest list[IMPORT_TIMES];
    struct digest base; /* zero: none */
};

/* Tells the outcome. fault NULL: the blobs are held objects (objects.h), which the caller releases.
 * cpu_us is that of the child. */
typedef void (*import_process_done)(void *ctx, const struct fault *fault,
                                    const struct import_blobs *blobs, uint64_t cpu_us);

/* Starts the child. The scene is copied. `done` comes later, once. ERR_MEMORY. */
int import_process_start(const struct import_options *options, const struct job *scene,
                         const struct import_times *times, import_process_done done, void *ctx,
                         struct import_process **out);

/* Kills the child; `done` is not called. Memory goes when all handles are closed. Nulls the
 * pointer. */
void import_process_cancel(struct import_process **process);
