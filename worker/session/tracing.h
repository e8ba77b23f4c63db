#pragma once
/* The work behind the link: loading a scene or an environment map, and tracing a tile. It is a
 * table of functions, so that the protocol can be tested without tracing rays. */
#include <stdatomic.h>
#include <stdbool.h>

#include "proto/bytes.h"
#include "proto/counter.h"
#include "proto/packing.h"
#include "proto/plan.h"

/* The kind of a blob, by its first bytes. */
enum tracing_kind { TRACING_SCENE, TRACING_ENVIRONMENT, TRACING_BASE };

/* What loading took. */
struct tracing_cost {
    uint64_t bytes;            /* of memory that the blob holds, roughly */
    uint64_t cpu_us;           /* of loading */
    uint64_t reused_triangles; /* triangles in the base's trees */
};

/* A pass of a tile, and the loaded blobs it is traced with; all borrowed. */
struct tracing_job {
    const void *scene;       /* loaded as one */
    const void *environment; /* the plan's map; NULL: it has none */
    const void *photograph;  /* the plan's; the same */
    const struct plan *plan;
    const struct plan_pass *pass;
    struct rect rect;
    _Atomic uint64_t *progress; /* grows by the tile's rows */
    const _Atomic bool *stop;   /* true: trace ends with ERR_STATE */
    enum packing packing;
    struct counters *counters;
};

struct tracing {
    void *ctx;
    uint32_t capabilities;                    /* bits of enum capability */
    const char *(*embree_version)(void *ctx); /* NULL: Embree does not work here */

    /* Reads which base the blob at `path` stands on; zero: on none. May be NULL. Blocks. */
    int (*find_base)(void *ctx, const char *path, struct digest *base);

    /* Opens the blob at `path`, on its base if it has one, and prepares it for tracing, with up to
     * `threads` threads. Blocks; any thread may call it. *steps grows with its progress. */
    int (*load)(void *ctx, const char *path, const void *base, unsigned threads,
                _Atomic uint64_t *steps, void **loaded, enum tracing_kind *kind,
                struct tracing_cost *cost, struct fault *fault);
    void (*unload)(void *ctx, void **loaded);

    /* Create and destroy the scratch memory of one thread. */
    int (*tracer_create)(void *ctx, void **tracer);
    void (*tracer_destroy)(void *ctx, void **tracer);

    /* Traces the job and packs its samples into *packed. ERR_STATE when stopped, ERR_MAGIC for a
     * blob that was loaded as the other kind. */
    int (*trace)(void *ctx, void *tracer, const struct tracing_job *job,
                 struct bytes_writer *packed);
};

/* The implementation by Embree. */
extern const struct tracing tracing_embree;
