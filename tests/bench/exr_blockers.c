/* What a shadow's error owes to the blocker that its slopes are taken from.
 *
 *     exr_blockers BLOB JOB.json REFERENCE.exr
 *
 * Traces the job's light field once; slopes come from the closest blockers (the worker's own), and
 * a second time from whatever blocker an any-hit ray with a recording filter function meets first
 * on the same rays. Both go through the job's shadow filter. Prints one JSON line: RMSE of direct
 * light before albedo, over the pixels that the reference sees between 2 and 98 %, and how many
 * pixels' slopes differ. One light, no instances. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"
#include "server/film/gather.h"
#include "server/image/exr.h"
#include "server/job/plan/plan.h"
#include "server/reconstruct/shadow/shadow.h"
#include "tests/bench/noting.h"
#include "worker/tile/tile.h"
#include "worker/trace/hit/queries.h"

enum { FILTER_BLOCK_PX = 64 };

static void fail(const char *what)
{
    fprintf(stderr, "exr_blockers: %s\n", what);
    exit(1);
}

/* Slopes of any blockers of the block of 4 x 4 pixels that is being traced. */
struct noter {
    struct query_recorder base;
    RTCScene scene;
    float least[LANES], most[LANES]; /* t of blocked rays; most 0: none is */
};

static void note_packet(struct query_recorder *self, enum query_kind kind,
                        const struct lanes_mask *valid, const struct RTCRayHit16 *asked)
{
    struct noter *noter = (struct noter *)self;
    struct RTCRay16 rays = asked->ray;
    struct noting_context context;
    if (kind != QUERY_BLOCKER) return;
    for (unsigned int i = 0; i < LANES; i++) rays.id[i] = i;
    noting_init(&context, true);
    rtcOccluded16(valid->on, noter->scene, &context.base, &rays);
    for (int i = 0; i < LANES; i++) {
        if (!valid->on[i] || !(rays.tfar[i] < 0.0f)) continue;
        const float t = fmaxf(context.distance[i], 0x1p-14f);
        noter->least[i] = noter->most[i] > 0.0f ? fminf(noter->least[i], t) : t;
        noter->most[i] = fmaxf(noter->most[i], t);
    }
}

struct field {
    struct plan plan;
    struct patch *patch; /* the whole picture; slopes of closest blockers */
    float *least, *most; /* slopes of any blockers */
};

/* One block of sixteen pixels: the recorder's lanes are then these. */
static void trace_block(struct tile_tracer *tracer, const struct render_scene *scene,
                        struct noter *noter, int32_t x0, int32_t y0, struct field *f)
{
    const struct rect all = f->patch->rect;
    const struct rect rect = rect_intersect((struct rect){x0, y0, x0 + 4, y0 + 4}, all);
    struct samples *samples;
    struct counters counters = {0};
    memset(noter->most, 0, sizeof noter->most);
    if (tile_trace(tracer,
                   &(struct tile_job){
                       .scene = scene, .plan = &f->plan, .rect = rect, .counters = &counters},
                   0, &samples))
        fail("a tile cannot be traced");
    const struct plan_pass pass = plan_scheduled_pass(&f->plan, 0);
    gather_tile(&f->plan, samples, pass_counts_of(&pass), rect, f->patch);
    samples_destroy(&samples);
    for (int i = 0; i < LANES; i++) {
        const int32_t x = x0 + i % 4, y = y0 + i / 4;
        if (x >= all.x1 || y >= all.y1 || !(noter->most[i] > 0.0f)) continue;
        const size_t at = (size_t)y * (size_t)all.x1 + (size_t)x;
        f->least[at] = noter->least[i] / (1.0f - noter->least[i]);
        f->most[at] = noter->most[i] / (1.0f - noter->most[i]);
    }
}

static void trace_field(const struct scene *blob, const struct render_scene *scene, struct field *f)
{
    const struct rect all = {0, 0, f->plan.width_px, f->plan.height_px};
    struct noter noter = {.base.record = note_packet, .scene = noting_scene(blob, scene->device)};
    struct tile_tracer *tracer = NULL;
    if (!noter.scene) fail("the scene has instances");
    if (patch_create(&f->plan, all, &f->patch) || tile_tracer_create(&tracer)) fail("no memory");
    f->least = calloc((size_t)rect_area(all), sizeof(float));
    f->most = calloc((size_t)rect_area(all), sizeof(float));
    if (!f->least || !f->most) fail("no memory");
    tile_tracer_queries(tracer)->recorder = &noter.base;
    for (int32_t y = 0; y < all.y1; y += 4)
        for (int32_t x = 0; x < all.x1; x += 4) trace_block(tracer, scene, &noter, x, y, f);
    tile_tracer_destroy(&tracer);
    rtcReleaseScene(noter.scene);
}

/* RMSE of the filtered picture over the reference's penumbrae. */
static double error_of(const struct field *f, const struct image *reference)
{
    const struct plane *seen = image_plane(reference, "visibility.V");
    const struct plane *red = image_plane(reference, "diffuse_direct.R");
    const struct rect all = f->patch->rect;
    struct shadow_statistics statistics = {0};
    float *e = calloc((size_t)rect_area(all), sizeof *e);
    double sum = 0.0;
    size_t count = 0;
    if (!e) fail("no memory");
    if (!seen || !red) fail("the reference lacks diffuse_direct or visibility");
    for (int32_t y = 0; y < all.y1; y += FILTER_BLOCK_PX)
        for (int32_t x = 0; x < all.x1; x += FILTER_BLOCK_PX) {
            const struct rect block = {x, y, x + FILTER_BLOCK_PX, y + FILTER_BLOCK_PX};
            if (shadow_filter(&f->plan, 0, f->patch, rect_intersect(block, all), e, NULL,
                              &statistics))
                fail("the filter refuses");
        }
    for (int32_t i = 0; i < rect_area(all); i++) {
        const int32_t x = i % all.x1, y = i / all.x1;
        const double v = (double)*plane_at(seen, x, y);
        const double d =
            (double)e[i] * (double)f->plan.lights[0].color[0] / M_PI - (double)*plane_at(red, x, y);
        if (!(v > 0.02 && v < 0.98)) continue;
        sum += d * d;
        count++;
    }
    free(e);
    return sqrt(sum / (double)(count ? count : 1));
}

static void make_plan(const char *path, const struct scene *blob, struct plan *plan)
{
    static char text[LIMIT_JOB_BYTES];
    static struct plan_report report;
    struct fault fault = {0};
    struct job job;
    const struct plan_source source = {.scene = blob};
    FILE *file = fopen(path, "rb");
    if (!file) fail(path);
    const size_t size_bytes = fread(text, 1, sizeof text, file);
    fclose(file);
    if (job_read(text, size_bytes, &job, &fault)) fail(fault.detail);
    if (plan_make(&job, &source, 0, plan, &report, &fault)) fail(fault.detail);
    job_fini(&job);
    if (plan->light_count != 1 || plan->shadow_filter == SHADOW_FILTER_NONE)
        fail("the job has no shadow filter or not one light");
}

int main(int argc, char **argv)
{
    static struct scene blob;
    static struct field f;
    struct fault fault = {0};
    struct render_scene *scene;
    struct image *reference;
    size_t differ = 0, occluded = 0;
    if (argc != 4) fail("usage: exr_blockers BLOB JOB.json REFERENCE.exr");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &scene, &fault)) fail(fault.detail);
    if (exr_read(argv[3], &reference, &fault)) fail(fault.detail);
    make_plan(argv[2], &blob, &f.plan);
    if (reference->width_px != f.plan.width_px || reference->height_px != f.plan.height_px)
        fail("the reference is of another size");
    trace_field(&blob, scene, &f);
    const double closest = error_of(&f, reference);
    struct patch_light *light = &f.patch->lights[0];
    for (int32_t i = 0; i < rect_area(f.patch->rect); i++) {
        if (!(light->slope_max[i] > 0.0f)) continue;
        occluded++;
        differ +=
            light->slope_min[i] < 0.99f * f.least[i] || light->slope_max[i] < 0.99f * f.most[i];
        light->slope_min[i] = f.least[i];
        light->slope_max[i] = f.most[i];
    }
    const double any = error_of(&f, reference);
    printf("{\"scene\": \"%s\", \"strata\": %u, \"closest_rmse\": %.5f, \"any_hit_rmse\": %.5f, "
           "\"any_hit_over_closest\": %.3f, \"slopes_differ\": %.3f}\n",
           argv[1], f.plan.lights[0].strata_per_axis * f.plan.lights[0].strata_per_axis, closest,
           any, any / closest, (double)differ / (double)(occluded ? occluded : 1));
    image_destroy(&reference);
    patch_destroy(&f.patch);
    render_scene_destroy(&scene);
    scene_unmap(&blob);
    return 0;
}
