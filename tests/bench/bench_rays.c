/* Rays per second of the worker's sample loop beside bare Embree.
 *
 *     bench_rays BLOB [THREADS]
 *
 * Records the camera and shadow rays of a 720 x 720 frame at 9 samples a pixel without bounces,
 * replays them through nothing but Embree calls, and traces the same frame with tile_trace.
 * Replayed rays lie ready in cache, copying them there is not timed; of packets as the worker
 * asked, full packets and streams the best counts. Prints one JSON line with both and one with
 * every effect on. Times are CPU times of the tracing threads, medians over interleaved
 * repetitions. */
#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <xmmintrin.h>

#include "worker/tile.h"
#include "worker/trace/queries.h"

enum { SIDE_PX = 720, TILE_PX = 64, STRATA = 3, CHUNK = 2048, REPETITIONS = 7, THREADS_MAX = 64 };

#define MXCSR_FLUSH 0x8040u

/* Rays of one kind in the order in which they were asked, sixteen lanes a packet; `count` lanes are
 * on. Lanes that are off have a mask of 0. */
struct recording {
    struct RTCRay *rays;
    size_t lanes, count, capacity;
};

struct recorder {
    struct query_recorder base;
    struct recording kinds[QUERY_KIND_COUNT];
};

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void fail(const char *text)
{
    fprintf(stderr, "bench_rays: %s\n", text);
    exit(1);
}

static void recording_add(struct recording *r, const struct RTCRay *ray)
{
    if (r->lanes == r->capacity) {
        size_t capacity = r->capacity ? 2 * r->capacity : 65536;
        struct RTCRay *grown = aligned_alloc(64, capacity * sizeof *grown);
        if (!grown) fail("no memory for the recording");
        if (r->lanes) memcpy(grown, r->rays, r->lanes * sizeof *grown);
        free(r->rays);
        r->rays = grown;
        r->capacity = capacity;
    }
    r->rays[r->lanes++] = *ray;
    if (ray->mask) r->count++;
}

static void record(struct query_recorder *self, enum query_kind kind,
                   const struct lanes_mask *valid, const struct RTCRayHit16 *q)
{
    struct recorder *recorder = (struct recorder *)self;
    const struct RTCRay16 *r = &q->ray;
    for (int i = 0; i < LANES; i++) {
        struct RTCRay ray = {.mask = 0};
        if (valid->on[i])
            ray = (struct RTCRay){r->org_x[i], r->org_y[i], r->org_z[i], r->tnear[i],
                                  r->dir_x[i], r->dir_y[i], r->dir_z[i], 0.0f,
                                  r->tfar[i],  r->mask[i],  0,           0};
        recording_add(&recorder->kinds[kind], &ray);
    }
}

/* A chunk of rays in the three layouts that Embree takes. */
struct chunk {
    struct RTCRayHit16 hits16[CHUNK / 16];
    struct RTCRay16 rays16[CHUNK / 16];
    struct RTCRayHit8 hits8[CHUNK / 8];
    struct RTCRay8 rays8[CHUNK / 8];
    struct RTCRayHit hits1[CHUNK];
    struct RTCRay rays1[CHUNK];
    _Alignas(64) int valid[CHUNK];
};

#define FILL(to, lane, ray)                                                                        \
    do {                                                                                           \
        (to).org_x[lane] = (ray).org_x, (to).org_y[lane] = (ray).org_y;                            \
        (to).org_z[lane] = (ray).org_z, (to).tnear[lane] = (ray).tnear;                            \
        (to).dir_x[lane] = (ray).dir_x, (to).dir_y[lane] = (ray).dir_y;                            \
        (to).dir_z[lane] = (ray).dir_z, (to).time[lane] = 0.0f;                                    \
        (to).tfar[lane] = (ray).tfar, (to).mask[lane] = (ray).mask;                                \
        (to).id[lane] = (to).flags[lane] = 0;                                                      \
    } while (0)

enum layout { LAYOUT_ASKED, LAYOUT_16, LAYOUT_8, LAYOUT_STREAM, LAYOUT_COUNT };
static const char *const layout_names[] = {"packets as asked", "packets of 16", "packets of 8",
                                           "streams"};

/* Lays out the rays in c->rays1 as one layout needs them. */
static void chunk_lay_out(struct chunk *c, bool closest, enum layout layout)
{
    for (int i = 0; i < CHUNK; i++) {
        const struct RTCRay *ray = &c->rays1[i];
        c->valid[i] = ray->mask ? -1 : 0;
        if (layout <= LAYOUT_16 && closest) FILL(c->hits16[i / 16].ray, i % 16, *ray);
        if (layout <= LAYOUT_16 && !closest) FILL(c->rays16[i / 16], i % 16, *ray);
        if (layout == LAYOUT_8 && closest) FILL(c->hits8[i / 8].ray, i % 8, *ray);
        if (layout == LAYOUT_8 && !closest) FILL(c->rays8[i / 8], i % 8, *ray);
        if (layout == LAYOUT_STREAM && closest) {
            memset(&c->hits1[i].hit, 0xff, sizeof c->hits1[i].hit);
            c->hits1[i].ray = *ray;
        }
    }
    if (layout <= LAYOUT_16 && closest)
        for (int i = 0; i < CHUNK / 16; i++)
            memset(&c->hits16[i].hit, 0xff, sizeof c->hits16[i].hit);
    if (layout == LAYOUT_8 && closest)
        for (int i = 0; i < CHUNK / 8; i++) memset(&c->hits8[i].hit, 0xff, sizeof c->hits8[i].hit);
}

/* The next chunk of a recording from lane *at on, with the gaps between asked rays or without. How
 * many rays are on; 0 when too few are left. */
static size_t chunk_fill(struct chunk *c, const struct recording *r, bool closest,
                         enum layout layout, size_t *at)
{
    size_t n = 0, on = 0;
    bool gaps = layout == LAYOUT_ASKED;
    for (; n < CHUNK && *at < r->lanes; ++*at)
        if (gaps || r->rays[*at].mask) {
            c->rays1[n++] = r->rays[*at];
            on += r->rays[*at].mask != 0;
        }
    if (n < CHUNK) return 0;
    chunk_lay_out(c, closest, layout);
    return on;
}

static void replay(const struct render_scene *render, struct chunk *c, bool closest,
                   enum layout layout)
{
    RTCScene scene = render->top;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    /* worker/trace/queries.c says why instances go without the hint */
    if (closest || !render->has_instances) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    if (layout <= LAYOUT_16 && closest)
        for (int i = 0; i < CHUNK / 16; i++)
            rtcIntersect16(c->valid + (size_t)16 * (size_t)i, scene, &context, &c->hits16[i]);
    else if (layout <= LAYOUT_16)
        for (int i = 0; i < CHUNK / 16; i++)
            rtcOccluded16(c->valid + (size_t)16 * (size_t)i, scene, &context, &c->rays16[i]);
    else if (layout == LAYOUT_8 && closest)
        for (int i = 0; i < CHUNK / 8; i++)
            rtcIntersect8(c->valid + (size_t)8 * (size_t)i, scene, &context, &c->hits8[i]);
    else if (layout == LAYOUT_8)
        for (int i = 0; i < CHUNK / 8; i++)
            rtcOccluded8(c->valid + (size_t)8 * (size_t)i, scene, &context, &c->rays8[i]);
    else if (closest)
        for (int i = 0; i < CHUNK; i += 1024)
            rtcIntersect1M(scene, &context, &c->hits1[i], 1024, sizeof c->hits1[0]);
    else
        for (int i = 0; i < CHUNK; i += 1024)
            rtcOccluded1M(scene, &context, &c->rays1[i], 1024, sizeof c->rays1[0]);
}

/* How far a recording has been replayed in one layout, and how long Embree alone took for that. */
struct progress {
    size_t lane, rays;
    double cpu_s;
};

/* Replays the next chunk; nothing when too few rays are left. */
static void replay_chunk(const struct render_scene *scene, struct chunk *c,
                         const struct recording *r, bool closest, enum layout layout,
                         struct progress *p)
{
    size_t on = chunk_fill(c, r, closest, layout, &p->lane);
    if (on == 0) return;
    unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    double start = cpu_s();
    replay(scene, c, closest, layout);
    p->cpu_s += cpu_s() - start;
    p->rays += on;
    _mm_setcsr(mode);
}

/* One thread's share: every `step`-th tile. */
struct share {
    const struct render_scene *scene;
    const struct plan *plan;
    uint32_t first, step;
    struct tile_tracer *tracer;
    struct chunk *chunk;
    struct recorder recorder;
    struct counters counters;
    double worker_s, bare_s[2][LAYOUT_COUNT]; /* camera, shadow */
    struct progress progress[2][LAYOUT_COUNT];
    bool replaying;
};

static const enum query_kind bare_kinds[2] = {QUERY_CAMERA, QUERY_SHADOW};

/* Keeps every layout of both kinds as far along as the tiles are: what disturbs the machine then
 * disturbs both alike. */
static void replay_upto(struct share *s, double part)
{
    for (int k = 0; k < 2; k++)
        for (enum layout l = 0; l < LAYOUT_COUNT; l++) {
            const struct recording *r = &s->recorder.kinds[bare_kinds[k]];
            struct progress *p = &s->progress[k][l];
            size_t before = p->lane + 1;
            while (p->lane < (size_t)(part * (double)r->lanes) && p->lane != before) {
                before = p->lane;
                replay_chunk(s->scene, s->chunk, r, k == 0, l, p);
            }
        }
}

static void trace_one(struct share *s, struct rect rect)
{
    struct samples *samples;
    double start = cpu_s();
    if (tile_trace(s->tracer, s->scene, NULL, s->plan, 0, rect, NULL, NULL, &samples, &s->counters))
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
        if (s->replaying) replay_upto(s, (double)i / tile_grid_count(&grid));
    }
    if (s->replaying) replay_upto(s, 1.0);
    for (int k = 0; k < 2; k++)
        for (int l = 0; l < LAYOUT_COUNT; l++) {
            const struct progress *p = &s->progress[k][l];
            double all = (double)s->recorder.kinds[bare_kinds[k]].count;
            s->bare_s[k][l] = p->rays ? p->cpu_s * all / (double)p->rays : 0.0;
        }
    return NULL;
}

static void run_all(struct share *shares, uint32_t threads, bool replaying)
{
    pthread_t ids[THREADS_MAX];
    for (uint32_t i = 0; i < threads; i++) {
        shares[i].replaying = replaying;
        if (pthread_create(&ids[i], NULL, share_run, &shares[i])) fail("no thread");
    }
    for (uint32_t i = 0; i < threads; i++) pthread_join(ids[i], NULL);
}

static float extent(const struct scene *s)
{
    float sum = 0.0f;
    for (int i = 0; i < 3; i++) {
        float side = s->info->bounds_max[i] - s->info->bounds_min[i];
        sum += side * side;
    }
    return sqrtf(sum);
}

/* A square light up and to the camera's side of a scene that has none. */
static void add_light(const struct scene *s, struct plan *p)
{
    float size = extent(s), length = 0.0f;
    struct plan_light *light = &p->lights[p->light_count++];
    *light = (struct plan_light){.type = LIGHT_RECTANGLE, .color = {1, 1, 1}, .power = 1.0f};
    for (int i = 0; i < 3; i++) {
        float up = p->camera.up[i], back = -p->camera.forward[i], right = p->camera.right[i];
        float centre = 0.5f * (s->info->bounds_min[i] + s->info->bounds_max[i]);
        float way = 0.8f * up + 0.6f * back + 0.3f * right;
        light->position[i] = centre + size * way;
        light->direction[i] = -way;
        length += way * way;
        light->half_u[i] = right;
    }
    float *n = light->direction, *u = light->half_u, *v = light->half_v, along = 0.0f, side = 0.0f;
    for (int i = 0; i < 3; i++) n[i] /= sqrtf(length);
    for (int i = 0; i < 3; i++) along += u[i] * n[i];
    for (int i = 0; i < 3; i++) u[i] -= along * n[i];
    for (int i = 0; i < 3; i++) side += u[i] * u[i];
    for (int i = 0; i < 3; i++) u[i] *= 0.1f * size / sqrtf(side);
    v[0] = n[1] * u[2] - n[2] * u[1];
    v[1] = n[2] * u[0] - n[0] * u[2];
    v[2] = n[0] * u[1] - n[1] * u[0];
}

static void add_scene_lights(const struct scene *s, struct plan *p)
{
    for (uint64_t i = 0; i < s->count[SCENE_LIGHTS] && p->light_count < LIMIT_LIGHTS; i++) {
        const struct scene_light *from = &s->lights[i];
        struct plan_light *to = &p->lights[p->light_count++];
        to->type = from->type;
        to->profile = from->profile;
        memcpy(to->position, from->position, sizeof to->position);
        memcpy(to->direction, from->direction, sizeof to->direction);
        memcpy(to->half_u, from->half_u, sizeof to->half_u);
        memcpy(to->half_v, from->half_v, sizeof to->half_v);
        memcpy(to->color, from->color, sizeof to->color);
        to->cos_inner = from->cos_inner;
        to->cos_outer = from->cos_outer;
        to->range = from->range;
        to->power = 1.0f;
    }
    if (p->light_count == 0) add_light(s, p);
    for (uint32_t i = 0; i < p->light_count; i++)
        p->lights[i].strata_per_axis = p->lights[i].type == LIGHT_RECTANGLE ? STRATA : 1;
}

static void plan_init(const struct scene *s, struct plan *p)
{
    const struct scene_camera *c = &s->cameras[s->info->default_camera];
    *p = (struct plan){.width_px = SIDE_PX, .height_px = SIDE_PX, .tile_px = TILE_PX};
    p->pattern.seed = 1;
    p->camera.type = c->type;
    memcpy(p->camera.eye, c->eye, sizeof c->eye);
    memcpy(p->camera.right, c->right, sizeof c->right);
    memcpy(p->camera.up, c->up, sizeof c->up);
    memcpy(p->camera.forward, c->forward, sizeof c->forward);
    p->camera.half_height =
        c->type == CAMERA_ORTHOGRAPHIC ? c->half_height : tanf(0.5f * c->yfov_rad);
    p->camera.half_width = p->camera.half_height;
    add_scene_lights(s, p);
    p->planes = 1u << PLANE_DEPTH | 1u << PLANE_NORMAL | 1u << PLANE_ALBEDO | 1u << PLANE_ID;
    p->light_planes = 1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY;
    p->radiance_scale = 1.0f;
    p->length_unit = exp2f(ceilf(log2f(0.5f * extent(s))));
}

/* The same frame with anti-aliasing, a bounce and slopes. */
static void plan_add_all(struct plan *p)
{
    p->sub_samples = LIMIT_SUB_SAMPLES;
    p->bounces = 1;
    p->indirect_strata_per_axis = STRATA;
    p->light_planes |= 1u << LIGHT_PLANE_SLOPES;
    p->planes |= 1u << PLANE_SUB_DEPTH | 1u << PLANE_SUB_NORMAL | 1u << PLANE_SUB_ALBEDO |
                 1u << PLANE_SUB_ID | 1u << PLANE_EMISSION | 1u << PLANE_INDIRECT_MEAN |
                 1u << PLANE_INDIRECT_HALVES | 1u << PLANE_REFLECTOR;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *v, size_t count)
{
    qsort(v, count, sizeof *v, compare_doubles);
    return v[count / 2];
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
    double worker[REPETITIONS], bare[2][LAYOUT_COUNT][REPETITIONS];
    for (uint32_t i = 0; i < threads; i++) {
        shares[i].recorder.base.record = record;
        tile_tracer_queries(shares[i].tracer)->recorder = &shares[i].recorder.base;
    }
    run_all(shares, threads, false);
    for (uint32_t i = 0; i < threads; i++) tile_tracer_queries(shares[i].tracer)->recorder = NULL;
    run_all(shares, threads, false); /* warm */
    for (int r = 0; r < REPETITIONS; r++) {
        run_all(shares, threads, true);
        worker[r] = 0.0;
        for (uint32_t i = 0; i < threads; i++) worker[r] += shares[i].worker_s;
        for (int k = 0; k < 2; k++)
            for (int l = 0; l < LAYOUT_COUNT; l++) {
                bare[k][l][r] = 0.0;
                for (uint32_t i = 0; i < threads; i++) bare[k][l][r] += shares[i].bare_s[k][l];
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
    double scale = 1e-6 * threads, worker_s = median(worker, REPETITIONS);
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
        run_all(shares, threads, false);
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
    struct fault fault = {0};
    struct scene blob;
    struct render_scene *scene;
    struct plan plan;
    long threads = argc > 2 ? strtol(argv[2], NULL, 10) : 1;
    if (argc < 2 || threads < 1 || threads > THREADS_MAX) fail("usage: bench_rays BLOB [THREADS]");
    if (scene_map(argv[1], &blob, &fault)) fail(fault.detail);
    if (render_scene_create(&blob, 1, &scene, &fault)) fail(fault.detail);
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
    bench_against_bare(name, shares, (uint32_t)threads);
    plan_add_all(&plan);
    bench_all_effects(name, shares, (uint32_t)threads);
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
