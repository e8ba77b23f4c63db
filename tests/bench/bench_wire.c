/* Bytes of samples as they travel beside the entropy of what they hold.
 *
 *     bench_wire BLOB JOB.json
 *
 * Traces the job's first frame and packs each tile in both ways. The entropy is an estimate from
 * above: of each component the least, over all filters (plane_filter.h), of the entropy of each
 * byte of its numbers by itself, as an ideal coder that learns nothing of their order would need;
 * tables of how often bytes come are not counted. Prints one JSON line; of a pixel:
 *   raw, quick, small, entropy   bytes
 *   over_entropy                 small over entropy
 *   quick_ns, small_ns           CPU time of packing; unquick_ns, unsmall_ns: of unpacking */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "proto/plane_filter.h"
#include "proto/samples_layout.h"
#include "proto/tile.h"
#include "server/job/plan/plan.h"
#include "tests/bench/job_file.h"
#include "tests/bench/timing.h"
#include "worker/tile/tile.h"

#define PIXELS_MAX ((size_t)LIMIT_TILE_SIDE_PX * LIMIT_TILE_SIDE_PX)

struct wire {
    double pixels, raw, entropy;
    double bytes[2], pack_s[2], unpack_s[2]; /* by enum packing */
};

static void fail(const char *what)
{
    fprintf(stderr, "bench_wire: %s\n", what);
    exit(1);
}

/* Bytes that `count` of them, `stride` apart, need. */
static double entropy_bytes(const uint8_t *bytes, size_t count, size_t stride)
{
    double often[256] = {0}, bits = 0.0;
    for (size_t i = 0; i < count; i++) often[bytes[i * stride]] += 1.0;
    for (int b = 0; b < 256; b++)
        if (often[b] > 0.0) bits -= often[b] * log2(often[b] / (double)count);
    return bits / 8.0;
}

static double component_entropy(const void *numbers, uint32_t element_bytes, int32_t width_px,
                                int32_t height_px)
{
    static uint8_t filtered[4 * PIXELS_MAX];
    const size_t count = (size_t)width_px * (size_t)height_px;
    double least = INFINITY;
    for (int k = 0; k < PLANE_FILTER_COUNT; k++) {
        double sum = 0.0;
        plane_filter_apply((enum plane_filter)k, numbers, element_bytes, width_px, height_px,
                           filtered);
        for (size_t b = 0; b < element_bytes; b++)
            sum += entropy_bytes(filtered + b, count, element_bytes);
        least = fmin(least, sum);
    }
    return least;
}

static void add_entropy(const struct samples *s, struct wire *wire)
{
    const struct samples_layout *layout = &s->layout;
    const size_t area = (size_t)layout->width_px * (size_t)layout->height_px;
    const uint8_t *at = s->data;
    for (uint32_t group = 0; group < SAMPLES_GROUP_COUNT; group++) {
        const uint32_t element = samples_element_bytes(group);
        const uint8_t *const end = at + layout->group_bytes[group];
        for (; at < end; at += area * element)
            wire->entropy += component_entropy(at, element, layout->width_px, layout->height_px);
    }
    wire->entropy += (double)sparse_list_bytes(s->lone); /* few: as they are */
    wire->raw += (double)samples_bytes(s);
    wire->pixels += (double)area;
}

static void add_packed(const struct plan *plan, uint32_t pass, struct samples *s,
                       enum packing packing, struct wire *wire)
{
    struct bytes_writer w;
    struct samples *back;
    struct fault fault = {0};
    const double begin_s = cpu_s();
    bytes_writer_init(&w);
    if (samples_pack(s, packing, &w, NULL)) fail("no memory");
    const double packed_s = cpu_s();
    if (samples_unpack(w.data, w.size_bytes, plan, pass, s->layout.width_px, s->layout.height_px,
                       &back, &fault))
        fail(fault.detail);
    wire->unpack_s[packing] += cpu_s() - packed_s;
    wire->pack_s[packing] += packed_s - begin_s;
    wire->bytes[packing] += (double)w.size_bytes;
    samples_destroy(&back);
    bytes_writer_fini(&w);
}

static void add_tile(struct tile_tracer *tracer, const struct render_scene *scene,
                     const struct plan *plan, struct rect rect, struct wire *wire)
{
    struct counters counters = {0};
    for (uint32_t pass = 0; pass < plan_pass_count(plan); pass++) {
        struct samples *samples;
        if (tile_trace(tracer,
                       &(struct tile_job){
                           .scene = scene, .plan = plan, .rect = rect, .counters = &counters},
                       pass, &samples))
            fail("a tile cannot be traced");
        add_entropy(samples, wire);
        add_packed(plan, pass, samples, PACKING_QUICK, wire);
        add_packed(plan, pass, samples, PACKING_SMALL, wire);
        samples_destroy(&samples);
    }
}

static void report(const struct wire *w)
{
    const double px = w->pixels, ns = 1e9 / px;
    const double small = w->bytes[PACKING_SMALL] / px, entropy = w->entropy / px;
    printf("{\"raw\": %.3f, \"quick\": %.3f, \"small\": %.3f, \"entropy\": %.3f, "
           "\"over_entropy\": %.3f, \"quick_ns\": %.1f, \"unquick_ns\": %.1f, \"small_ns\": %.1f, "
           "\"unsmall_ns\": %.1f}\n",
           w->raw / px, w->bytes[PACKING_QUICK] / px, small, entropy, small / entropy,
           w->pack_s[PACKING_QUICK] * ns, w->unpack_s[PACKING_QUICK] * ns,
           w->pack_s[PACKING_SMALL] * ns, w->unpack_s[PACKING_SMALL] * ns);
}

int main(int argc, char **argv)
{
    static struct plan plan;
    static struct plan_report plan_report;
    static struct scene blob;
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct tile_grid grid;
    struct fault fault = {0};
    struct job job;
    struct wire wire = {0};
    if (argc != 3) fail("usage: bench_wire BLOB JOB.json");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &scene, &fault)) fail(fault.detail);
    if (tile_tracer_create(&tracer)) fail("no memory");
    read_job(argv[2], &job);
    const struct plan_source source = {.scene = &blob};
    if (plan_make(&job, &source, 0, &plan, &plan_report, &fault)) fail(fault.detail);
    if (tile_grid_init(&grid, plan.width_px, plan.height_px, plan.tile_px)) fail("no tiles");
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++)
        add_tile(tracer, scene, &plan, tile_grid_rect(&grid, t), &wire);
    report(&wire);
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    job_fini(&job);
    scene_unmap(&blob);
    return 0;
}
