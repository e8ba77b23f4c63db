#include "worker/session/tracing.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "proto/link/message.h"
#include "proto/runtime/clock.h"
#include "proto/samples.h"
#include "proto/scene/environment.h"
#include "proto/scene/scene.h"
#include "worker/scene/environment.h"
#include "worker/scene/render_scene.h"
#include "worker/tile/tile.h"

/* A BVH over fewer triangles is built faster than threads are woken for it. */
#define PARALLEL_TRIANGLES 1000000u
/* Embree's BVH and our tables, per triangle; measured between 60 and 110. */
#define BYTES_PER_TRIANGLE 100u

struct loaded_scene {
    struct scene blob;
    struct render_scene *render;
};

struct loaded_environment {
    struct environment_blob blob;
    struct environment *map;
};

struct loaded {
    enum tracing_kind kind;
    struct loaded_scene scene;
    struct loaded_environment environment;
};

static const char *embree_version(void *ctx)
{
    (void)ctx;
    return render_embree_version();
}

/* ---- blobs ---- */

static void unload(void *ctx, void **loaded)
{
    (void)ctx;
    struct loaded *l = *loaded;
    *loaded = NULL;
    if (!l) return;
    render_scene_destroy(&l->scene.render);
    scene_unmap(&l->scene.blob);
    environment_destroy(&l->environment.map);
    environment_unmap(&l->environment.blob);
    free(l);
}

/* Returns the kind by the first bytes. scene_map refuses a file that is neither. */
static enum tracing_kind kind_of(const char *path)
{
    char magic[sizeof ENVIRONMENT_MAGIC] = "";
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return TRACING_SCENE;
    const ssize_t n = pread(fd, magic, sizeof magic, 0);
    close(fd);
    return n == (ssize_t)sizeof magic && memcmp(magic, ENVIRONMENT_MAGIC, sizeof magic) == 0
               ? TRACING_ENVIRONMENT
               : TRACING_SCENE;
}

static uint64_t reused_triangles(const struct scene *blob)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; i < blob->count[SCENE_MESHES]; i++)
        if (blob->meshes[i].flags & MESH_IN_BASE) sum += blob->meshes[i].triangle_count;
    return sum;
}

static int load_scene(struct loaded_scene *s, const char *path, const struct loaded_scene *base,
                      unsigned threads, _Atomic uint64_t *steps, struct tracing_cost *cost,
                      struct fault *fault)
{
    const uint64_t start_us = thread_cpu_us();
    int e = scene_map_on(path, base ? &base->blob : NULL, &s->blob, fault);
    if (e) return e;
    const uint64_t triangles = s->blob.count[SCENE_TRIANGLES];
    const unsigned used = triangles < PARALLEL_TRIANGLES ? 1 : threads;
    const clockid_t clock = used == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID;
    const uint64_t build_us = clock_us(clock), open_us = thread_cpu_us() - start_us;
    e = render_scene_create_on(&s->blob, base && s->blob.base ? base->render : NULL, used, steps,
                               &s->render, fault);
    if (e) return e;
    *cost = (struct tracing_cost){.bytes = s->blob.blob_bytes + BYTES_PER_TRIANGLE * triangles,
                                  .cpu_us = open_us + clock_us(clock) - build_us,
                                  .reused_triangles = reused_triangles(&s->blob)};
    return 0;
}

/* Photographs light nothing, so they need no tables. */
static int load_environment(struct loaded_environment *l, const char *path,
                            struct tracing_cost *cost, struct fault *fault)
{
    const uint64_t start_us = thread_cpu_us();
    int e = environment_map(path, &l->blob, fault);
    if (e) return e;
    *cost = (struct tracing_cost){.bytes = l->blob.blob_bytes};
    if (!(l->blob.header->flags & ENVIRONMENT_IS_PHOTOGRAPH)) {
        e = environment_create(&l->blob, &l->map);
        if (e) return fault_set(fault, e, path, "%s", error_text(e));
        cost->bytes += environment_bytes(l->map);
    }
    cost->cpu_us = thread_cpu_us() - start_us;
    return 0;
}

static int find_base(void *ctx, const char *path, struct digest *base)
{
    (void)ctx;
    return scene_find_base(path, base);
}

static int load(void *ctx, const char *path, const void *base, unsigned threads,
                _Atomic uint64_t *steps, void **loaded, enum tracing_kind *kind,
                struct tracing_cost *cost, struct fault *fault)
{
    struct loaded *l = calloc(1, sizeof *l);
    const struct loaded *stands_on = base;
    void *all = l;
    if (!l) return fault_set(fault, ERR_MEMORY, path, "%s", error_text(ERR_MEMORY));
    l->kind = kind_of(path);
    const int e = l->kind == TRACING_SCENE
                      ? load_scene(&l->scene, path, stands_on ? &stands_on->scene : NULL, threads,
                                   steps, cost, fault)
                      : load_environment(&l->environment, path, cost, fault);
    if (e) {
        unload(ctx, &all);
        return e;
    }
    if (l->kind == TRACING_SCENE && l->scene.blob.info->flags & SCENE_IS_BASE)
        l->kind = TRACING_BASE;
    *kind = l->kind;
    *loaded = l;
    return 0;
}

/* ---- tiles ---- */

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

static int pack(struct samples *samples, const struct tracing_job *job, struct bytes_writer *packed)
{
    uint64_t dropped = 0, before_us = thread_cpu_us();
    const int e = samples_pack(samples, job->packing, packed, &dropped);
    job->counters->value[COUNTER_PACK_CPU_US] += thread_cpu_us() - before_us;
    job->counters->value[COUNTER_SKIPPED_EMPTY_PLANE] += dropped;
    return e;
}

static int trace(void *ctx, void *tracer, const struct tracing_job *job,
                 struct bytes_writer *packed)
{
    (void)ctx;
    const struct loaded *scene = job->scene, *around = job->environment;
    const struct loaded *photograph = job->photograph;
    struct samples *samples = NULL;
    if (scene->kind != TRACING_SCENE || (around && !around->environment.map) ||
        (photograph && photograph->kind != TRACING_ENVIRONMENT))
        return ERR_MAGIC;
    const struct tile_job tile = {.scene = scene->scene.render,
                                  .environment = around ? around->environment.map : NULL,
                                  .photograph = photograph ? &photograph->environment.blob : NULL,
                                  .plan = job->plan,
                                  .pass = job->pass,
                                  .rect = job->rect,
                                  .progress = job->progress,
                                  .stop = job->stop,
                                  .counters = job->counters};
    int e = tile_trace_pass(tracer, &tile, &samples);
    if (e == 0) e = pack(samples, job, packed);
    samples_destroy(&samples);
    return e;
}

const struct tracing tracing_embree = {
    .capabilities = CAPABILITY_DIRECT | CAPABILITY_INDIRECT | CAPABILITY_VISIBILITY |
                    CAPABILITY_STRATA | CAPABILITY_PATHS | CAPABILITY_ENVIRONMENT |
                    CAPABILITY_LENS | CAPABILITY_STRATA_MAPS | CAPABILITY_VIEWS |
                    CAPABILITY_SHUTTER,
    .embree_version = embree_version,
    .find_base = find_base,
    .load = load,
    .unload = unload,
    .tracer_create = tracer_create,
    .tracer_destroy = tracer_destroy,
    .trace = trace,
};
