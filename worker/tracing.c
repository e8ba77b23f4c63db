#include "worker/tracing.h"

#include <stdlib.h>
#include <time.h>

#include "proto/message.h"
#include "proto/samples.h"
#include "proto/scene.h"
#include "worker/scene/render_scene.h"
#include "worker/tile.h"

/* A BVH over fewer triangles is built faster than threads are woken for it. */
#define PARALLEL_TRIANGLES 1000000u
/* Embree's BVH and our tables, per triangle; measured between 60 and 110. */
#define BYTES_PER_TRIANGLE 100u

struct loaded_scene {
    struct scene blob;
    struct render_scene *render;
};

static uint64_t cpu_us(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (uint64_t)t.tv_sec * 1000000u + (uint64_t)t.tv_nsec / 1000u;
}

static const char *embree_version(void *ctx)
{
    (void)ctx;
    return render_embree_version();
}

static void unload(void *ctx, void **scene)
{
    (void)ctx;
    struct loaded_scene *s = *scene;
    *scene = NULL;
    if (!s) return;
    render_scene_destroy(&s->render);
    scene_unmap(&s->blob);
    free(s);
}

static int load(void *ctx, const char *path, unsigned threads, void **scene, uint64_t *bytes,
                uint64_t *spent_us, struct fault *fault)
{
    (void)ctx;
    struct loaded_scene *s = calloc(1, sizeof *s);
    if (!s) return fault_set(fault, ERR_MEMORY, path, "%s", error_text(ERR_MEMORY));
    uint64_t mine_us = cpu_us(CLOCK_THREAD_CPUTIME_ID);
    int e = scene_map(path, &s->blob, fault);
    if (e) {
        free(s);
        return e;
    }
    uint64_t triangles = s->blob.count[SCENE_TRIANGLES];
    unsigned used = triangles < PARALLEL_TRIANGLES ? 1 : threads;
    uint64_t all_us = cpu_us(CLOCK_PROCESS_CPUTIME_ID);
    mine_us = cpu_us(CLOCK_THREAD_CPUTIME_ID) - mine_us;
    uint64_t build_us = cpu_us(CLOCK_THREAD_CPUTIME_ID);
    e = render_scene_create(&s->blob, used, &s->render, fault);
    if (e) {
        scene_unmap(&s->blob);
        free(s);
        return e;
    }
    build_us = used == 1 ? cpu_us(CLOCK_THREAD_CPUTIME_ID) - build_us
                         : cpu_us(CLOCK_PROCESS_CPUTIME_ID) - all_us;
    *spent_us = mine_us + build_us;
    *bytes = s->blob.blob_bytes + BYTES_PER_TRIANGLE * triangles;
    *scene = s;
    return 0;
}

static int tracer_create(void *ctx, void **tracer)
{
    (void)ctx;
    struct tile_tracer *t = NULL;
    int e = tile_tracer_create(&t);
    *tracer = t;
    return e;
}

static void tracer_destroy(void *ctx, void **tracer)
{
    (void)ctx;
    struct tile_tracer *t = *tracer;
    *tracer = NULL;
    tile_tracer_destroy(&t);
}

static int trace(void *ctx, void *tracer, const void *scene, const struct plan *plan,
                 struct rect rect, _Atomic uint64_t *progress, const _Atomic bool *stop,
                 struct bytes_writer *packed, struct counters *counters)
{
    (void)ctx;
    const struct loaded_scene *s = scene;
    struct samples *samples = NULL;
    int e = tile_trace(tracer, s->render, NULL, plan, 0, rect, progress, stop, &samples, counters);
    if (e) return e;
    uint64_t dropped = 0, before_us = cpu_us(CLOCK_THREAD_CPUTIME_ID);
    e = samples_pack(samples, packed, &dropped);
    samples_destroy(&samples);
    counters->value[COUNTER_PACK_CPU_US] += cpu_us(CLOCK_THREAD_CPUTIME_ID) - before_us;
    counters->value[COUNTER_SKIPPED_EMPTY_PLANE] += dropped;
    return e;
}

const struct tracing tracing_embree = {
    .capabilities =
        CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY | CAPABILITY_STRATA,
    .embree_version = embree_version,
    .load = load,
    .unload = unload,
    .tracer_create = tracer_create,
    .tracer_destroy = tracer_destroy,
    .trace = trace,
};
