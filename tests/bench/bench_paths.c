/* Paths per CPU second of the worker's path tracer beside bare Embree on the same rays.
 *
 *     bench_paths BLOB [BOUNCES [SPP]]
 *
 * Traces a 720 x 720 frame on one thread, records a part of its rays and replays them through
 * nothing but Embree calls, bounces in packets of 16 as asked, packed full, packets of 8 and
 * streams, of which the best counts. Prints one JSON line; times are CPU times, medians over
 * interleaved repetitions. */
#include <stdio.h>

#include "tests/bench/bench_plan.h"
#include "tests/bench/recording.h"
#include "worker/process/malloc_tuning.h"
#include "worker/tile/tile.h"

enum { REPETITIONS = 5, RECORDED_ROWS_PX = 64 };

/* What is asked of Embree along a path: which kinds, and how. */
static const struct asked {
    enum query_kind kind;
    bool closest, coherent;
} asked[] = {
    {QUERY_CAMERA, true, true},
    {QUERY_BOUNCE, true, false},
    {QUERY_SHADOW, false, true},
    {QUERY_BOUNCE_SHADOW, false, false},
};
#define ASKED (sizeof asked / sizeof asked[0])

struct bench {
    struct scene blob;
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct plan plan;
    struct recorder recorder;
    struct chunk *chunk;
};

static void trace(struct bench *b, struct rect rect, struct counters *counters)
{
    struct samples *samples;
    for (uint32_t pass = 0; pass < plan_pass_count(&b->plan); pass++) {
        if (tile_trace(b->tracer,
                       &(struct tile_job){
                           .scene = b->scene, .plan = &b->plan, .rect = rect, .counters = counters},
                       pass, &samples))
            fail("a tile cannot be traced");
        samples_destroy(&samples);
    }
}

static void trace_frame(struct bench *b, int32_t y_end_px, struct counters *counters)
{
    for (int32_t y = 0; y < y_end_px; y += TILE_PX)
        for (int32_t x = 0; x < SIDE_PX; x += TILE_PX) {
            struct rect rect = {x, y, x + TILE_PX < SIDE_PX ? x + TILE_PX : SIDE_PX,
                                y + TILE_PX < SIDE_PX ? y + TILE_PX : SIDE_PX};
            trace(b, rect, counters);
        }
}

/* A band through the middle of the picture stands for all of it. */
static void record_band(struct bench *b)
{
    struct counters counters = {0};
    int32_t y0 = (SIDE_PX - RECORDED_ROWS_PX) / 2;
    b->recorder.base.record = record;
    tile_tracer_queries(b->tracer)->recorder = &b->recorder.base;
    for (int32_t x = 0; x + TILE_PX <= SIDE_PX; x += TILE_PX)
        trace(b, (struct rect){x, y0, x + TILE_PX, y0 + RECORDED_ROWS_PX}, &counters);
    tile_tracer_queries(b->tracer)->recorder = NULL;
}

/* Seconds of Embree for one ray of a kind, in the best layout. */
static double bare_ray_s(struct bench *b, const struct asked *a)
{
    const struct recording *r = &b->recorder.kinds[a->kind];
    double best = INFINITY;
    for (enum layout l = 0; l < LAYOUT_COUNT; l++) {
        struct progress p = {0};
        size_t before = SIZE_MAX;
        while (p.lane != before) {
            before = p.lane;
            replay_chunk(b->scene, b->chunk, r, a->closest, a->coherent, l, &p);
        }
        if (p.rays > 0 && p.cpu_s / (double)p.rays < best) best = p.cpu_s / (double)p.rays;
    }
    return best < INFINITY ? best : 0.0;
}

static uint64_t rays(const struct counters *c)
{
    return c->value[COUNTER_RAYS_PRIMARY] + c->value[COUNTER_RAYS_INDIRECT] +
           c->value[COUNTER_RAYS_SHADOW] + c->value[COUNTER_RAYS_INDIRECT_SHADOW];
}

static double bare_s(struct bench *b, const struct counters *c)
{
    static const enum counter_id ids[ASKED] = {COUNTER_RAYS_PRIMARY, COUNTER_RAYS_INDIRECT,
                                               COUNTER_RAYS_SHADOW, COUNTER_RAYS_INDIRECT_SHADOW};
    double sum = 0.0;
    for (size_t k = 0; k < ASKED; k++) sum += (double)c->value[ids[k]] * bare_ray_s(b, &asked[k]);
    return sum;
}

static void report(const char *name, struct bench *b)
{
    double worker[REPETITIONS], bare[REPETITIONS];
    struct counters counters = {0};
    record_band(b);
    for (int i = 0; i < REPETITIONS; i++) {
        memset(&counters, 0, sizeof counters);
        double start = cpu_s();
        trace_frame(b, SIDE_PX, &counters);
        worker[i] = cpu_s() - start;
        bare[i] = bare_s(b, &counters);
    }
    double paths = (double)counters.value[COUNTER_PATHS], all = (double)rays(&counters);
    double worker_s = median(worker, REPETITIONS), embree_s = median(bare, REPETITIONS);
    printf("{\"scene\": \"%s\", \"bounces\": %u, \"spp\": %u, \"mpaths_s\": %.3f, "
           "\"rays_per_path\": %.2f, \"worker_mrays_s\": %.2f, \"bare_mrays_s\": %.2f, "
           "\"ratio\": %.3f, \"bare_bounce_mrays_s\": %.2f, \"triangles\": %llu}\n",
           name, b->plan.bounces, b->plan.paths.spp, paths / worker_s * 1e-6, all / paths,
           all / worker_s * 1e-6, all / embree_s * 1e-6, embree_s / worker_s,
           1e-6 / bare_ray_s(b, &asked[1]), (unsigned long long)b->blob.info->placed_triangles);
}

int main(int argc, char **argv)
{
    struct fault fault = {0};
    static struct bench b;
    malloc_tuning_apply(); /* as the worker does */
    if (argc < 2) fail("usage: bench_paths BLOB [BOUNCES [SPP]]");
    if (scene_map(argv[1], &b.blob, &fault)) fail(fault.detail);
    if (render_scene_create(&b.blob, 1, NULL, &b.scene, &fault)) fail(fault.detail);
    b.chunk = aligned_alloc(64, sizeof *b.chunk);
    if (!b.chunk || tile_tracer_create(&b.tracer)) fail("no memory");
    plan_init(&b.blob, &b.plan);
    b.plan.planes = PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(PATH_COVERAGE);
    b.plan.light_planes = 0;
    b.plan.bounces = argc > 2 ? (uint32_t)atoi(argv[2]) : 8;
    b.plan.paths.spp = argc > 3 ? (uint32_t)atoi(argv[3]) : 16;
    report(argv[1], &b);
    return 0;
}
