/* exr_reference BLOB JOB.json STRATA SEED OUT.exr: direct light at pixel centres, converged.
 *
 * The integral is the product's: its camera rays, its lights, its shadow rays. The samples are not:
 * every stratum has a jitter of its own, so that the error falls as N^-3/4 where a penumbra's edge
 * crosses the light, while one jitter shared by a pixel's strata leaves it at N^-1/2. Each pixel
 * gets SCOUT x SCOUT strata first; blocks of 4 x 4 pixels where some of them are blocked and some
 * are not get STRATA x STRATA. Writes diffuse_direct, and visibility as the mean over all lights
 * with area of those samples. */
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "proto/job/job.h"
#include "server/image/exr.h"
#include "server/job/plan/plan_parts.h"
#include "tests/bench/job_file.h"
#include "tests/bench/threads.h"
#include "worker/scene/emitters.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/light/light_kernels.h"

enum { SCOUT = 32, STRATA_MAX = 1024 };

#define MXCSR_FLUSH 0x8040u

struct reference {
    const struct render_scene *scene;
    const struct plan *plan;
    struct light_table lights;
    uint32_t strata;
    uint64_t seed;
    const struct plane *direct[3], *visibility;
    _Atomic int32_t next_row; /* blocks, from the top */
};

/* A thread's own. */
struct tracer {
    struct queries queries;
    const struct light_kernels *kernels;
    struct RTCRayHit16 camera;
    struct surface surface;
    struct block block;
    struct light_packet packet;
};

/* What one light gives a block. */
struct sums {
    double irradiance[LANES], seen[LANES]; /* means over the strata */
    bool mixed; /* somewhere in the block some strata are seen and some are not */
};

static void fail(const char *what)
{
    fprintf(stderr, "exr_reference: %s\n", what);
    exit(1);
}

/* Two numbers in [0, 1) that depend on everything: the finaliser of MurmurHash3, twice. */
static uint32_t mix(uint32_t h)
{
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

static void place(const uint32_t key[LANES], uint32_t stratum, uint32_t l, float u[LANES],
                  float v[LANES])
{
    float column = (float)(stratum % l), row = (float)(stratum / l), inverse = 1.0f / (float)l;
    for (int i = 0; i < LANES; i++) {
        uint32_t a = mix(key[i] + stratum * 0x9e3779b9u), b = mix(a ^ 0x68bc21ebu);
        u[i] = (column + (float)(a >> 8) * 0x1p-24f) * inverse;
        v[i] = (row + (float)(b >> 8) * 0x1p-24f) * inverse;
    }
}

static void make_keys(const struct reference *r, const struct block *b, uint32_t light, uint32_t l,
                      uint32_t key[LANES])
{
    uint32_t base = mix((uint32_t)r->seed * 0x9e3779b9u ^ mix(light * 2048 + l));
    for (int i = 0; i < LANES; i++)
        key[i] = mix(base ^ mix((uint32_t)b->y_px[i] << 16 ^ (uint32_t)b->x_px[i]));
}

static void gather(const struct reference *r, struct tracer *t, uint32_t light, uint32_t l,
                   struct sums *out)
{
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES];
    uint32_t key[LANES], blocked[LANES] = {0}, count = l * l;
    const struct light_packet *p = &t->packet;
    *out = (struct sums){.mixed = false};
    make_keys(r, &t->block, light, l, key);
    for (uint32_t s = 0; s < count; s++) {
        place(key, s, l, u, v);
        t->kernels->sample_light(&r->lights.lights[light], u, v, &t->surface, &t->surface.hit,
                                 &t->packet);
        if (lanes_count(&p->traced) > 0)
            queries_occluded(&t->queries, QUERY_SHADOW, &p->traced, &t->packet.rays);
        for (int i = 0; i < LANES; i++) {
            bool hidden = p->traced.on[i] && p->rays.ray.tfar[i] < 0.0f;
            blocked[i] += hidden;
            if (p->traced.on[i] && !hidden) out->irradiance[i] += (double)p->irradiance[i];
        }
    }
    for (int i = 0; i < LANES; i++) {
        out->irradiance[i] /= count;
        out->seen[i] = 1.0 - (double)blocked[i] / count;
        out->mixed = out->mixed || (blocked[i] > 0 && blocked[i] < count);
    }
}

/* All lights' light at a block, into the planes. */
static void trace_block(const struct reference *r, struct tracer *t)
{
    double direct[3][LANES] = {{0}}, seen[LANES] = {0};
    uint32_t areas = 0;
    primary_trace(&t->queries, r->plan, &t->block, &t->camera, &t->surface);
    for (uint32_t k = 0; k < r->plan->light_count; k++) {
        const struct plan_light *light = &r->plan->lights[k];
        bool area = light->type == LIGHT_RECTANGLE;
        struct sums sums;
        gather(r, t, k, area ? SCOUT : 1, &sums);
        if (area && sums.mixed) gather(r, t, k, r->strata, &sums);
        areas += area;
        for (int i = 0; i < LANES; i++) {
            for (int c = 0; c < 3; c++)
                direct[c][i] += sums.irradiance[i] * (double)light->color[c] / M_PI;
            if (area) seen[i] += sums.seen[i];
        }
    }
    for (int i = 0; i < LANES; i++) {
        if (!t->block.kept.on[i] || !t->surface.hit.on[i]) continue;
        int32_t x = t->block.x_px[i], y = t->block.y_px[i];
        for (int c = 0; c < 3; c++) *plane_at(r->direct[c], x, y) = (float)direct[c][i];
        *plane_at(r->visibility, x, y) = areas > 0 ? (float)(seen[i] / areas) : 1.0f;
    }
}

static void *run(void *context)
{
    struct reference *r = context;
    const struct plan *plan = r->plan;
    struct tracer *t = aligned_alloc(LANES_ALIGN, sizeof *t);
    if (!t) fail("no memory");
    memset(t, 0, sizeof *t);
    queries_init(&t->queries);
    queries_init_rays(&t->camera);
    queries_init_rays(&t->packet.rays);
    t->queries.scene = r->scene;
    t->queries.kernels = KERNELS_FOR(hit_kernels, r->scene->isa);
    t->kernels = KERNELS_FOR(light_kernels, r->scene->isa);
    _mm_setcsr(_mm_getcsr() | MXCSR_FLUSH);
    struct rect all = {0, 0, plan->width_px, plan->height_px};
    for (int32_t y; (y = LANES_ACROSS * atomic_fetch_add(&r->next_row, 1)) < all.y1;)
        for (int32_t x = 0; x < all.x1; x += LANES_ACROSS) {
            block_init(&t->block, x, y, all.x1, all.y1, all);
            trace_block(r, t);
        }
    free(t);
    return NULL;
}

/* Camera and lights of the job, as any frame of it has them. */
static void make_plan(const struct job *job, const struct scene *blob, struct plan *plan)
{
    static struct plan_report report;
    struct fault fault = {0};
    *plan = (struct plan){.width_px = job->width_px, .height_px = job->height_px};
    if (plan_resolve_camera(job, blob, &plan->camera, &report, &fault)) fail(fault.detail);
    if (plan_gather_lights(job, blob, plan, &report, &fault)) fail(fault.detail);
}

static struct image *trace(struct reference *r)
{
    static const char *const names[] = {"diffuse_direct.R", "diffuse_direct.G", "diffuse_direct.B",
                                        "visibility.V"};
    struct image *image = NULL;
    if (image_create_named(names, 4, r->plan->width_px, r->plan->height_px, &image))
        fail("no memory");
    for (int c = 0; c < 3; c++) r->direct[c] = image_plane(image, names[c]);
    r->visibility = image_plane(image, names[3]);
    light_table_init(&r->lights, r->plan, emitters_tree(r->scene->emitters));
    if (run_on_all_cores(run, r)) fail("no thread");
    return image;
}

int main(int argc, char **argv)
{
    static struct plan plan;
    static struct reference r;
    struct fault fault = {0};
    struct scene blob;
    struct render_scene *scene;
    struct job job;
    if (argc != 6) fail("usage: exr_reference BLOB JOB.json STRATA SEED OUT.exr");
    r.strata = (uint32_t)strtoul(argv[3], NULL, 10);
    r.seed = strtoull(argv[4], NULL, 10);
    if (r.strata < 1 || r.strata > STRATA_MAX) fail("STRATA is not 1 .. 1024");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, NULL, &scene, &fault)) fail(fault.detail);
    read_job(argv[2], &job);
    make_plan(&job, &blob, &plan);
    r.scene = scene;
    r.plan = &plan;
    struct image *image = trace(&r);
    int error = exr_write(argv[5], image, &(struct exr_metadata){.seed = r.seed}, &fault);
    if (error) fprintf(stderr, "exr_reference: %s: %s\n", argv[5], fault.detail);
    image_destroy(&image);
    job_fini(&job);
    render_scene_destroy(&scene);
    scene_unmap(&blob);
    return error ? 1 : 0;
}
