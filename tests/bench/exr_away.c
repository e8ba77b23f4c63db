/* exr_away BLOB JOB.json OUT.exr: where a picture through a lens is away from silhouettes: 1 where
 * the slopes of a pixel's 256 lens samples lie within one pixel, else 0. Written as the layer
 * visibility, which is one that pictures can be compared by. */
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include "proto/half.h"
#include "proto/job/job.h"
#include "server/image/exr.h"
#include "server/job/plan/plan_parts.h"
#include "tests/bench/job_file.h"
#include "tests/bench/threads.h"
#include "worker/tile/tile.h"

enum { TILE_PX = 32 };

#define RANGE_MAX_PX 1.0f

struct away {
    const struct render_scene *scene;
    const struct plan *plan;
    struct tile_grid grid;
    const struct plane *out;
    _Atomic uint32_t next_tile;
};

static void fail(const char *what)
{
    fprintf(stderr, "exr_away: %s\n", what);
    exit(1);
}

static bool is_away(const struct samples *s, size_t i)
{
    float least = INFINITY, most = -INFINITY;
    for (uint32_t k = 0; k < s->layout.lens_strata; k++) {
        const float slope = half_to_float(samples_u16(s, PLANE_LENS_SLOPE, k)[i]);
        least = fminf(least, slope);
        most = fmaxf(most, slope);
    }
    return most - least <= RANGE_MAX_PX;
}

static void *run(void *context)
{
    struct away *a = context;
    struct tile_tracer *tracer;
    struct counters counters = {0};
    if (tile_tracer_create(&tracer)) fail("no memory");
    for (uint32_t t; (t = atomic_fetch_add(&a->next_tile, 1)) < tile_grid_count(&a->grid);) {
        const struct rect r = tile_grid_rect(&a->grid, t);
        struct samples *samples;
        if (tile_trace(tracer,
                       &(struct tile_job){
                           .scene = a->scene, .plan = a->plan, .rect = r, .counters = &counters},
                       0, &samples))
            fail("a tile could not be traced");
        size_t i = 0;
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++, i++)
                *plane_at(a->out, x, y) = is_away(samples, i) ? 1.0f : 0.0f;
        samples_destroy(&samples);
    }
    tile_tracer_destroy(&tracer);
    return NULL;
}

/* The job's camera, in the dark: only where samples land counts. */
static void make_plan(const struct job *job, const struct scene *blob, struct plan *plan)
{
    static struct plan_report report;
    struct fault fault = {0};
    *plan = (struct plan){.width_px = job->width_px,
                          .height_px = job->height_px,
                          .tile_px = TILE_PX,
                          .pattern.seed = job->seed,
                          .planes = PLANE_BIT(LENS_RADIANCE) | PLANE_BIT(LENS_SLOPE),
                          .lens_strata_per_axis = LIMIT_PLANE_STRATA_PER_AXIS,
                          .radiance_scale = 1,
                          .length_unit = 1,
                          .mu = 1};
    if (plan_resolve_camera(job, blob, &plan->camera, &report, &fault)) fail(fault.detail);
    if (!(plan->camera.aperture_radius > 0)) fail("the job has no lens");
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"visibility.V"};
    static struct plan plan;
    static struct away a;
    struct fault fault = {0};
    struct image *image = NULL;
    struct render_scene *scene;
    struct scene blob;
    struct job job;
    if (argc != 4) fail("usage: exr_away BLOB JOB.json OUT.exr");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &scene, &fault)) fail(fault.detail);
    read_job(argv[2], &job);
    make_plan(&job, &blob, &plan);
    if (image_create_named(names, 1, plan.width_px, plan.height_px, &image)) fail("no memory");
    if (tile_grid_init(&a.grid, plan.width_px, plan.height_px, TILE_PX)) fail("no tiles");
    a.out = image_plane(image, names[0]);
    a.scene = scene;
    a.plan = &plan;
    if (run_on_all_cores(run, &a)) fail("no thread");
    const int error = exr_write(argv[3], image, &(struct exr_metadata){.seed = job.seed}, &fault);
    if (error) fprintf(stderr, "exr_away: %s: %s\n", argv[3], fault.detail);
    image_destroy(&image);
    job_fini(&job);
    render_scene_destroy(&scene);
    scene_unmap(&blob);
    return error ? 1 : 0;
}
