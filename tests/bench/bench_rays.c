/* Rays per second of the worker's sample loop beside bare Embree.
 *
 *     bench_rays BLOB [THREADS [TURNS]]
 *
 * With TURNS it traces the frame below so often and does nothing else, for a profiler.
 *
 * Records the camera and shadow rays of a 720 x 720 frame at 9 samples a pixel without bounces,
 * replays them through nothing but Embree calls, and traces the same frame with tile_trace.
 * Replayed rays lie ready in cache, copying them there is not timed; of packets as the worker
 * asked, full packets and streams the best counts. Each repetition replays one of these layouts
 * behind each tile: a second one would find the tree in cache where the first had just walked.
 * Prints one JSON line with both and one with every effect on. Times are CPU times of the tracing
 * threads, medians over interleaved repetitions. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/bench/bench_plan.h"
#include "tests/bench/recording.h"
#include "worker/process/malloc_tuning.h"
#include "worker/tile/tile.h"

enum { REPETITIONS = 7, THREADS_MAX = 64 };

/* One thread's share: every `step`-th tile. */
struct share {
    const struct render_scene *scene;
    const struct plan *plan;
    uint32_t first, step;
    struct tile_tracer *tracer;
    struct chunk *chunk;
    struct recorder recorder;
    struct counters counters;
    double worker_s, bare_s[2]; /* camera, shadow */
    struct progress progress[2];
    enum layout replayed; /* LAYOUT_COUNT: none */
};

static const enum query_kind bare_kinds[2] = {QUERY_CAMERA, QUERY_SHADOW};

/* Keeps the layout of both kinds as far along as the tiles are: what disturbs the machine then
 * disturbs both alike. */
static void replay_upto(struct share *s, double part)
{
    for (int k = 0; k < 2; k++) {
        const struct recording *r = &s->recorder.kinds[bare_kinds[k]];
        struct progress *p = &s->progress[k];
        size_t before = p->lane + 1;
        while (p->lane < (size_t)(part * (double)r->lanes) && p->lane != before) {
            before = p->lane;
            replay_chunk(s->scene, s->chunk, r, k == 0, true, s->replayed, p);
        }
    }
}

static void trace_one(struct share *s, struct rect rect)
{
    struct samples *samples;
    double start = cpu_s();
    if (tile_trace(s->tracer,
                   &(struct tile_job){
                       .scene = s->scene, .plan = s->plan, .rect = rect, .counters = &s->counters},
                   0, &samples))
        fail("a tile cannot be traced");
    samples_destroy(&samples);
    s->worker_s += cpu_s() - start;
}

static void *share_run(void *context)
{
    struct share *s = context;
    struct tile_grid grid;
    if (tile_grid_init(&grid, SIDE_PX, SIDE_PX, TILE_PX)) fail("the tiles do not fit");
    s->worker_s = 0.0;
    memset(s->progress, 0, sizeof s->progress);
    for (uint32_t i = s->first; i < tile_grid_count(&grid); i += s->step) {
        trace_one(s, tile_grid_rect(&grid, i));
        if (s->replayed < LAYOUT_COUNT) replay_upto(s, (double)i / tile_grid_count(&grid));
    }
    if (s->replayed < LAYOUT_COUNT) replay_upto(s, 1.0);
    for (int k = 0; k < 2; k++) {
        const struct progress *p = &s->progress[k];
        double all = (double)s->recorder.kinds[bare_kinds[k]].count;
        s->bare_s[k] = p->rays ? p->cpu_s * all / (double)p->rays : 0.0;
    }
    return NULL;
}

static void run_all(struct share *shares, uint32_t threads, enum layout replayed)
{
    pthread_t ids[THREADS_MAX];
    for (uint32_t i = 0; i < threads; i++) {
        shares[i].replayed = replayed;
        if (pthread_create(&ids[i], NULL, share_run, &shares[i])) fail("no thread");
    }
    for (uint32_t i = 0; i < threads; i++) pthread_join(ids[i], NULL);
}

/* The same frame with anti-aliasing, a bounce and slopes. */
static void plan_add_all(struct plan *p)
{
    p->sub_samples = LIMIT_SUB_SAMPLES;
    p->bounces = 1;
    p->indirect_strata_per_axis = STRATA;
    p->light_planes |= 1u << LIGHT_PLANE_SLOPES;
    p->planes |= PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |
                 PLANE_BIT(SUB_ID) | PLANE_BIT(EMISSION) | PLANE_BIT(INDIRECT_MEAN) |
                 PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(BOUNCE_DISTANCE_MIN);
}

/* Rays of camera and shadow kinds, and seconds summed over threads. */
static size_t recorded(const struct share *shares, uint32_t threads, enum query_kind kind)
{
    size_t sum = 0;
    for (uint32_t i = 0; i < threads; i++) sum += shares[i].recorder.kinds[kind].count;
    return sum;
}

static void bench_against_bare(const char *name, struct share *shares, uint32_t threads)
{
    double worker[REPETITIONS * LAYOUT_COUNT], bare[2][LAYOUT_COUNT][REPETITIONS];
    for (uint32_t i = 0; i < threads; i++) {
        shares[i].recorder.base.record = record;
        tile_tracer_queries(shares[i].tracer)->recorder = &shares[i].recorder.base;
    }
    run_all(shares, threads, LAYOUT_COUNT);
    for (uint32_t i = 0; i < threads; i++) tile_tracer_queries(shares[i].tracer)->recorder = NULL;
    run_all(shares, threads, LAYOUT_COUNT); /* warm */
    for (int r = 0; r < REPETITIONS; r++)
        for (enum layout l = 0; l < LAYOUT_COUNT; l++) {
            run_all(shares, threads, l);
            worker[r * LAYOUT_COUNT + (int)l] = 0.0;
            for (int k = 0; k < 2; k++) bare[k][l][r] = 0.0;
            for (uint32_t i = 0; i < threads; i++) {
                worker[r * LAYOUT_COUNT + (int)l] += shares[i].worker_s;
                for (int k = 0; k < 2; k++) bare[k][l][r] += shares[i].bare_s[k];
            }
        }
    double best[2] = {INFINITY, INFINITY};
    int layout[2] = {0, 0};
    for (int k = 0; k < 2; k++)
        for (int l = 0; l < LAYOUT_COUNT; l++) {
            double s = median(bare[k][l], REPETITIONS);
            if (s < best[k]) best[k] = s, layout[k] = l;
        }
    double camera = (double)recorded(shares, threads, QUERY_CAMERA);
    double shadow = (double)recorded(shares, threads, QUERY_SHADOW);
    double scale = 1e-6 * threads, worker_s = median(worker, REPETITIONS * LAYOUT_COUNT);
    double bare_rate = (camera + shadow) / (best[0] + best[1]) * scale;
    double worker_rate = (camera + shadow) / worker_s * scale;
    printf("{\"scene\": \"%s\", \"threads\": %u, \"bare_mrays_s\": %.2f, \"worker_mrays_s\": %.2f, "
           "\"ratio\": %.3f, \"bare_camera_mrays_s\": %.2f, \"bare_shadow_mrays_s\": %.2f, "
           "\"camera_layout\": \"%s\", \"shadow_layout\": \"%s\"}\n",
           name, threads, bare_rate, worker_rate, worker_rate / bare_rate, camera / best[0] * scale,
           shadow / best[1] * scale, layout_names[layout[0]], layout_names[layout[1]]);
}

static void bench_all_effects(const char *name, struct share *shares, uint32_t threads)
{
    double seconds[REPETITIONS];
    struct counters sum = {0};
    for (int r = 0; r < REPETITIONS; r++) {
        seconds[r] = 0.0;
        memset(&sum, 0, sizeof sum);
        for (uint32_t i = 0; i < threads; i++)
            memset(&shares[i].counters, 0, sizeof shares[i].counters);
        run_all(shares, threads, LAYOUT_COUNT);
        for (uint32_t i = 0; i < threads; i++) {
            seconds[r] += shares[i].worker_s;
            counters_add(&sum, &shares[i].counters);
        }
    }
    double s = median(seconds, REPETITIONS) / threads * 1e6, all = 0.0;
    printf("{\"scene\": \"%s\", \"threads\": %u, \"effects\": \"all\"", name, threads);
    for (enum counter_id id = COUNTER_RAYS_PRIMARY; id <= COUNTER_RAYS_INDIRECT_SHADOW; id++) {
        printf(", \"%s_mrays_s\": %.2f", counter_key(id), (double)sum.value[id] / s);
        all += (double)sum.value[id];
    }
    printf(", \"mrays_s\": %.2f}\n", all / s);
}

int main(int argc, char **argv)
{
    malloc_tuning_apply(); /* as the worker does */
    struct fault fault = {0};
    struct scene blob;
    struct render_scene *scene;
    struct plan plan;
    long threads = argc > 2 ? strtol(argv[2], NULL, 10) : 1;
    const long turns = argc > 3 ? strtol(argv[3], NULL, 10) : 0;
    if (argc < 2 || threads < 1 || threads > THREADS_MAX || turns < 0)
        fail("usage: bench_rays BLOB [THREADS [TURNS]]");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &scene, &fault)) fail(fault.detail);
    plan_init(&blob, &plan);
    struct share *shares = calloc((size_t)threads, sizeof *shares);
    if (!shares) fail("no memory");
    for (uint32_t i = 0; i < (uint32_t)threads; i++) {
        shares[i] = (struct share){.scene = scene, .plan = &plan, .first = i};
        shares[i].step = (uint32_t)threads;
        shares[i].chunk = aligned_alloc(64, (sizeof(struct chunk) + 63) / 64 * 64);
        if (!shares[i].chunk || tile_tracer_create(&shares[i].tracer)) fail("no memory");
    }
    const char *slash = strrchr(argv[1], '/');
    const char *name = slash ? slash + 1 : argv[1];
    for (long i = 0; i < turns; i++) run_all(shares, (uint32_t)threads, LAYOUT_COUNT);
    if (turns == 0) {
        bench_against_bare(name, shares, (uint32_t)threads);
        plan_add_all(&plan);
        bench_all_effects(name, shares, (uint32_t)threads);
    }
    for (uint32_t i = 0; i < (uint32_t)threads; i++) {
        for (int k = 0; k < QUERY_KIND_COUNT; k++) free(shares[i].recorder.kinds[k].rays);
        free(shares[i].chunk);
        tile_tracer_destroy(&shares[i].tracer);
    }
    free(shares);
    render_scene_destroy(&scene);
    scene_unmap(&blob);
    return 0;
}
