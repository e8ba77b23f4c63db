/* exr_lone BLOB JOB.json SPP [REPETITIONS]: what the shading of lone sub-samples costs and is
 * worth.
 *
 * The job's first frame is traced and reconstructed with and without the list of lone sub-samples,
 * and once with it, unfiltered, with SPP light samples at the same points of the picture: the
 * reference. Tracing is measured REPETITIONS times in turn, 7 unless said. Prints one JSON line:
 *   pixels    those that the list changes, as a share of all
 *   lone      lone sub-samples, as a share of all
 *   before, after   RMSE over these pixels and R, G, B, over the reference's mean luminance there,
 *             without the list and with it
 *   trace_s, lone_s   CPU time of tracing without it; what it takes more; medians
 *   cost      the latter over the former
 *   bytes     of the list as it travels, over all bytes of the samples */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"
#include "server/film/film.h"
#include "server/image/image.h"
#include "server/job/plan/plan.h"
#include "server/reconstruct/block.h"
#include "tests/bench/job_file.h"
#include "tests/bench/timing.h"
#include "worker/tile/tile.h"

enum { REPETITIONS = 7, MOST_REPETITIONS = 99 };

struct frame {
    struct plan plan;
    struct image *image; /* owned */
    struct counters counters;
    uint64_t lone, bytes;
};

static struct scene blob;
static struct render_scene *scene;
static struct tile_tracer *tracer;

static void fail(const char *what)
{
    fprintf(stderr, "exr_lone: %s\n", what);
    exit(1);
}

static void make_plan(const struct job *job, bool lone, struct plan *plan)
{
    static struct plan_report report;
    struct fault fault = {0};
    const struct plan_source source = {.scene = &blob};
    if (plan_make(job, &source, 0, plan, &report, &fault)) fail(fault.detail);
    if (!(plan->planes & PLANE_BIT(LONE))) fail("the job's plan has no lone sub-samples");
    if (!lone) plan->planes &= ~PLANE_BIT(LONE);
}

static struct samples *trace(struct frame *f, uint32_t pass, struct rect rect)
{
    struct samples *samples;
    if (tile_trace(tracer,
                   &(struct tile_job){
                       .scene = scene, .plan = &f->plan, .rect = rect, .counters = &f->counters},
                   pass, &samples))
        fail("a tile cannot be traced");
    return samples;
}

static uint64_t packed_bytes(struct samples *samples)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    if (samples_pack(samples, PACKING_QUICK, &w, NULL)) fail("no memory");
    const uint64_t bytes = w.size_bytes;
    bytes_writer_fini(&w);
    return bytes;
}

static void draw(struct frame *f, struct film *film)
{
    uint32_t block;
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        struct block_statistics statistics;
        if (film_gather(film, block, &patch)) fail("no memory");
        if (block_reconstruct(&f->plan, patch, film_block_rect(film, block), f->image, &statistics))
            fail("a block cannot be reconstructed");
        f->lone += statistics.sub_samples_lone;
        patch_destroy(&patch);
        film_block_done(film, block);
    }
}

static void render(struct frame *f)
{
    struct tile_grid grid;
    struct film *film;
    if (tile_grid_init(&grid, f->plan.width_px, f->plan.height_px, f->plan.tile_px) ||
        film_create(&f->plan, block_side_px(&f->plan), block_core_px(&f->plan),
                    block_halo_px(&f->plan), &film) ||
        image_create(LAYER_BEAUTY, f->plan.width_px, f->plan.height_px, &f->image))
        fail("no memory");
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++) {
        for (uint32_t pass = 0; pass < plan_pass_count(&f->plan); pass++) {
            struct samples *samples = trace(f, pass, tile_grid_rect(&grid, t));
            f->bytes += packed_bytes(samples);
            if (film_land(film, t, pass, samples)) fail("a tile does not land");
        }
    }
    draw(f, film);
    film_destroy(&film);
}

/* CPU seconds of tracing a frame's first pass. */
static double trace_s(struct frame *f)
{
    struct tile_grid grid;
    f->counters = (struct counters){0};
    tile_grid_init(&grid, f->plan.width_px, f->plan.height_px, f->plan.tile_px);
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++) {
        struct samples *samples = trace(f, 0, tile_grid_rect(&grid, t));
        samples_destroy(&samples);
    }
    return (double)f->counters.value[COUNTER_TRACE_CPU_US] * 1e-6;
}

static float value_at(const struct image *image, int c, int32_t x, int32_t y)
{
    static const char *const names[] = {"R", "G", "B"};
    return *plane_at(image_plane(image, names[c]), x, y);
}

struct errors {
    double before, after, luminance; /* sums */
    uint64_t pixels;
};

/* Over pixels in which the two differ. */
static struct errors judge(const struct frame *without, const struct frame *with,
                           const struct frame *reference)
{
    static const double weight[] = {0.2126, 0.7152, 0.0722};
    struct errors e = {0};
    for (int32_t y = 0; y < with->plan.height_px; y++)
        for (int32_t x = 0; x < with->plan.width_px; x++) {
            bool changed = false;
            for (int c = 0; c < 3; c++)
                changed |= value_at(without->image, c, x, y) != value_at(with->image, c, x, y);
            e.pixels += changed;
            for (int c = 0; c < 3 && changed; c++) {
                const double r = (double)value_at(reference->image, c, x, y);
                const double b = (double)value_at(without->image, c, x, y) - r;
                const double a = (double)value_at(with->image, c, x, y) - r;
                e.before += b * b;
                e.after += a * a;
                e.luminance += weight[c] * r;
            }
        }
    return e;
}

static void report(const struct frame *without, const struct frame *with, const struct errors *e,
                   double plain_s, double more_s)
{
    const double all = (double)with->plan.width_px * with->plan.height_px;
    const double count = e->pixels > 0 ? (double)e->pixels : 1.0;
    const double mean = e->luminance > 0 ? e->luminance / count : 1.0;
    printf("{\"pixels\": %.5f, \"lone\": %.5f, \"before\": %.5f, \"after\": %.5f, "
           "\"trace_s\": %.4f, \"lone_s\": %.4f, \"cost\": %.4f, \"bytes\": %.4f}\n",
           (double)e->pixels / all, (double)with->lone / (all * with->plan.sub_samples),
           sqrt(e->before / (3 * count)) / mean, sqrt(e->after / (3 * count)) / mean, plain_s,
           more_s, more_s / plain_s, 1.0 - (double)without->bytes / (double)with->bytes);
}

int main(int argc, char **argv)
{
    static struct frame with, without, reference;
    double plain_s[MOST_REPETITIONS], more_s[MOST_REPETITIONS];
    struct fault fault = {0};
    struct job job;
    if (argc < 4) fail("usage: exr_lone BLOB JOB.json SPP [REPETITIONS]");
    const size_t repetitions = argc > 4 ? strtoul(argv[4], NULL, 10) : REPETITIONS;
    if (repetitions < 1 || repetitions > MOST_REPETITIONS) fail("REPETITIONS are 1 to 99");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &scene, &fault)) fail(fault.detail);
    if (tile_tracer_create(&tracer)) fail("no memory");
    read_job(argv[2], &job);
    make_plan(&job, true, &with.plan);
    make_plan(&job, false, &without.plan);
    job.spp = (uint32_t)strtoul(argv[3], NULL, 10);
    job.method = FILTER_AVERAGE;
    make_plan(&job, true, &reference.plan);
    render(&with);
    render(&without);
    render(&reference);
    for (size_t i = 0; i < repetitions; i++) {
        plain_s[i] = trace_s(&without);
        more_s[i] = trace_s(&with) - plain_s[i];
    }
    const struct errors e = judge(&without, &with, &reference);
    report(&without, &with, &e, median(plain_s, repetitions), median(more_s, repetitions));
    image_destroy(&with.image);
    image_destroy(&without.image);
    image_destroy(&reference.image);
    tile_tracer_destroy(&tracer);
    job_fini(&job);
    render_scene_destroy(&scene);
    scene_unmap(&blob);
    return 0;
}
