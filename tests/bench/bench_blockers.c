/* How to learn a shadow ray's blocker: closest hits, or any hit with a filter that notes where.
 *
 *     bench_blockers BLOB
 *
 * Traces a 720 x 720 frame's shadow rays at 9 samples with slopes, records them and replays them
 * through nothing but Embree calls, in packets of 16 as asked: occlusion alone (which tells no
 * distance), occlusion with a filter function that notes the distance it was asked about, and
 * closest hits. Prints one JSON line: millions of rays per CPU second, medians. */
#include "tests/bench/bench_plan.h"
#include "tests/bench/noting.h"
#include "tests/bench/recording.h"
#include "worker/tile/tile.h"

enum { REPETITIONS = 7 };

enum way { WAY_OCCLUDED, WAY_NOTED, WAY_CLOSEST, WAY_COUNT };

/* Sinks what was found, so that nothing is optimised away. */
static volatile float sink;

static void ask(RTCScene scene, struct chunk *c, enum way way)
{
    struct noting_context context;
    noting_init(&context, way == WAY_NOTED);
    for (int i = 0; i < CHUNK / 16; i++) {
        const int *valid = c->valid + (size_t)16 * (size_t)i;
        if (way == WAY_CLOSEST)
            rtcIntersect16(valid, scene, &context.base, &c->hits16[i]);
        else
            rtcOccluded16(valid, scene, &context.base, &c->rays16[i]);
    }
    sink = context.distance[0];
}

static double rate(RTCScene scene, struct chunk *c, const struct recording *r, enum way way)
{
    struct progress p = {0};
    size_t on;
    unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    while ((on = chunk_fill(c, r, way == WAY_CLOSEST, LAYOUT_ASKED, &p.lane)) > 0) {
        double start = cpu_s();
        ask(scene, c, way);
        p.cpu_s += cpu_s() - start;
        p.rays += on;
    }
    _mm_setcsr(mode);
    return (double)p.rays / p.cpu_s * 1e-6;
}

static void record_frame(const struct scene *blob, const struct render_scene *scene,
                         struct recorder *recorder)
{
    static struct plan plan;
    struct tile_tracer *tracer;
    struct counters counters = {0};
    plan_init(blob, &plan);
    plan.light_planes = 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES;
    recorder->base.record = record;
    if (tile_tracer_create(&tracer)) fail("no memory");
    tile_tracer_queries(tracer)->recorder = &recorder->base;
    for (int32_t y = 0; y + TILE_PX <= SIDE_PX; y += TILE_PX)
        for (int32_t x = 0; x + TILE_PX <= SIDE_PX; x += TILE_PX) {
            struct samples *samples;
            struct rect rect = {x, y, x + TILE_PX, y + TILE_PX};
            if (tile_trace(tracer,
                           &(struct tile_job){
                               .scene = scene, .plan = &plan, .rect = rect, .counters = &counters},
                           0, &samples))
                fail("a tile cannot be traced");
            samples_destroy(&samples);
        }
    tile_tracer_destroy(&tracer);
}

int main(int argc, char **argv)
{
    static struct scene blob;
    static struct recorder recorder;
    struct fault fault = {0};
    struct render_scene *render;
    double mrays_s[WAY_COUNT][REPETITIONS];
    if (argc != 2) fail("usage: bench_blockers BLOB");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &render, &fault)) fail(fault.detail);
    record_frame(&blob, render, &recorder);
    RTCScene scene = noting_scene(&blob, render->device);
    if (!scene) fail("the scene has instances");
    struct chunk *chunk = aligned_alloc(64, sizeof *chunk);
    if (!chunk) fail("no memory");
    for (int k = 0; k < REPETITIONS; k++)
        for (int way = 0; way < WAY_COUNT; way++)
            mrays_s[way][k] = rate(scene, chunk, &recorder.kinds[QUERY_BLOCKER], (enum way)way);
    printf("{\"scene\": \"%s\", \"rays\": %zu, \"occluded_mrays_s\": %.2f, "
           "\"occluded_noting_mrays_s\": %.2f, \"closest_mrays_s\": %.2f}\n",
           argv[1], recorder.kinds[QUERY_BLOCKER].count, median(mrays_s[WAY_OCCLUDED], REPETITIONS),
           median(mrays_s[WAY_NOTED], REPETITIONS), median(mrays_s[WAY_CLOSEST], REPETITIONS));
    return 0;
}
