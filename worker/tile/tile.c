#include "worker/tile/tile.h"

#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "proto/runtime/clock.h"
#include "worker/scene/emitters.h"
#include "worker/tile/tile_work.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/path_kernels.h"

/* Flush to zero and denormals are zero (Intel SDM volume 1, 10.2.3). */
#define MXCSR_FLUSH 0x8040u

int tile_tracer_create(struct tile_tracer **out)
{
    struct tile_tracer *t = aligned_alloc(LANES_ALIGN, sizeof *t);
    if (!t) return ERR_MEMORY;
    memset(t, 0, sizeof *t);
    queries_init(&t->queries);
    queries_init_rays(&t->camera);
    for (int i = 0; i < PRIMARY_ROW; i++) queries_init_rays(&t->row[i].rays);
    for (int i = 0; i < SHADOW_BATCH; i++) queries_init_rays(&t->shadow.batch[i].rays);
    path_scratch_init(&t->path);
    lone_scratch_init(&t->lone);
    mixed_scratch_init(&t->mixed);
    matte_scratch_init(&t->mattes);
    *out = t;
    return 0;
}

void tile_tracer_destroy(struct tile_tracer **tracer)
{
    if (!*tracer) return;
    lone_scratch_fini(&(*tracer)->lone);
    mixed_scratch_fini(&(*tracer)->mixed);
    free(*tracer);
    *tracer = NULL;
}

struct queries *tile_tracer_queries(struct tile_tracer *tracer)
{
    return &tracer->queries;
}

static bool is_stopped(const _Atomic bool *stop)
{
    return stop && atomic_load_explicit(stop, memory_order_relaxed);
}

bool tile_shows(const struct tile_tracer *t, int32_t x, int32_t y)
{
    const struct rect pixels = {x, y, x + LANES_ACROSS, y + LANES_ACROSS};
    return !t->objects_only || lobe_view_meets(&t->lobes, pixels);
}

/* Finds which blocks show something. Returns whether any does. */
static bool find_shown(struct tile_tracer *t, int32_t x, int32_t y, int32_t count)
{
    bool any = false;
    for (int32_t k = 0; k < count; k++) {
        t->shows[k] = tile_shows(t, x + k * LANES_ACROSS, y);
        any |= t->shows[k];
    }
    return any;
}

/* Blocks from (x, y) on, at most PRIMARY_ROW, up to the tile's end. */
static int trace_blocks(struct tile_tracer *t, const struct stages *stages,
                        const struct tile_job *job, int32_t x, int32_t y, struct samples *samples)
{
    const struct plan *plan = job->plan;
    const int32_t left = (job->rect.x1 - x + LANES_ACROSS - 1) / LANES_ACROSS;
    const int32_t count = left < PRIMARY_ROW ? left : PRIMARY_ROW;
    if (!find_shown(t, x, y, count)) return 0;
    if (tile_sees_centres(stages))
        primary_trace_row(&t->queries, plan, x, y, (uint32_t)count, t->row);
    for (int32_t k = 0; k < count; k++, x += LANES_ACROSS) {
        if (!t->shows[k]) continue;
        block_init(&t->block, x, y, plan->width_px, plan->height_px, job->rect);
        tile_trace_block(t, stages, plan, &t->row[k], samples, job->counters);
        if (is_stopped(job->stop)) return ERR_STATE;
    }
    return 0;
}

void tile_count_rows(const struct tile_job *job, int32_t y)
{
    const struct rect rect = job->rect;
    const int32_t first = y > rect.y0 ? y : rect.y0;
    const int32_t end = y + LANES_ACROSS < rect.y1 ? y + LANES_ACROSS : rect.y1;
    if (job->progress)
        atomic_fetch_add_explicit(job->progress, (uint64_t)(end - first), memory_order_relaxed);
}

static int trace_rows(struct tile_tracer *t, const struct stages *stages,
                      const struct tile_job *job, struct samples *samples)
{
    const struct rect rect = job->rect;
    for (int32_t y = rect.y0 & -LANES_ACROSS; y < rect.y1; y += LANES_ACROSS) {
        for (int32_t x = rect.x0 & -LANES_ACROSS; x < rect.x1; x += PRIMARY_ROW * LANES_ACROSS)
            if (trace_blocks(t, stages, job, x, y, samples)) return ERR_STATE;
        if (!tile_is_of_paths(stages)) tile_count_rows(job, y);
    }
    return 0;
}

/* Traces, when all planes are there, sub-samples that none of the pixels around them shows, and
 * pixels that show several surfaces. */
static int trace_borders(struct tile_tracer *t, const struct stages *stages, struct rect rect,
                         struct samples *samples)
{
    const struct lone_tools tools = {&t->shadow, &t->indirect, &t->glossy, &t->path};
    int error = 0;
    if (samples->layout.lone_parts > 0)
        error = lone_trace(&stages->field, &tools, rect, &t->lone, samples);
    else
        lone_settle(&stages->field, rect, &t->lone, samples);
    if (error || samples->layout.mixed_values == 0) return error;
    return mixed_trace(&stages->field, &t->lone.finder, &t->mixed, samples);
}

/* Of the views of a composite, the one of the objects has them. */
static int trace_mattes(struct tile_tracer *t, const struct stages *stages,
                        const struct tile_job *job, struct samples *samples)
{
    const struct plan *plan = job->plan;
    const struct query_view *view = t->queries.view;
    if (!(samples->layout.planes & PLANES_MATTE)) return 0;
    if (view && view != query_view_of(PLAN_VIEW_OBJECTS)) return 0;
    for (int32_t y = job->rect.y0 & -LANES_ACROSS; y < job->rect.y1; y += LANES_ACROSS) {
        for (int32_t x = job->rect.x0 & -LANES_ACROSS; x < job->rect.x1; x += LANES_ACROSS) {
            block_init(&t->block, x, y, plan->width_px, plan->height_px, job->rect);
            mattes_trace(&stages->whole, &t->block, &t->mattes, samples);
        }
        if (is_stopped(job->stop)) return ERR_STATE;
    }
    return 0;
}

static bool rect_fits(const struct plan *plan, struct rect rect)
{
    return rect.x0 >= 0 && rect.y0 >= 0 && rect.x0 < rect.x1 && rect.y0 < rect.y1 &&
           rect.x1 <= plan->width_px && rect.y1 <= plan->height_px &&
           rect_width(rect) <= LIMIT_TILE_SIDE_PX && rect_height(rect) <= LIMIT_TILE_SIDE_PX;
}

static int check_job(const struct tile_job *job)
{
    const struct plan *plan = job->plan;
    const int e = rect_fits(plan, job->rect) ? plan_pass_check(plan, job->pass) : ERR_RANGE;
    if (e) return e;
    if (plan->environment.kind == ENVIRONMENT_MAP && !job->environment) return ERR_MISSING;
    if (plan->photograph.fit != PHOTOGRAPH_NONE && !job->photograph) return ERR_MISSING;
    return job->pass->strata_map ? plan_strata_map_check(job->pass, (size_t)rect_area(job->rect))
                                 : 0;
}

static int create_samples(const struct tile_job *job, struct samples **out)
{
    struct samples_layout layout;
    const int e = samples_layout_init(&layout, job->plan, job->pass->number, rect_width(job->rect),
                                      rect_height(job->rect));
    return e ? e : samples_create(&layout, out);
}

/* Points the tracer's tables at what the job is traced with, and chooses the stages. */
static void prepare(struct tile_tracer *t, const struct tile_job *job,
                    const struct sky_guide *guide, struct stages *stages)
{
    const struct render_scene *scene = job->scene;
    t->queries.scene = scene;
    t->queries.kernels = KERNELS_FOR(hit_kernels, scene->isa);
    t->queries.rejected = 0;
    light_table_init(&t->lights, job->plan, emitters_tree(scene->emitters));
    sky_init(&t->sky, &job->plan->environment, job->environment, guide);
    /* Catchers' views tell of changes alone, in the scene's light. */
    const bool seen = job->plan->photograph.fit != PHOTOGRAPH_NONE &&
                      t->queries.view == query_view_of(PLAN_VIEW_OBJECTS);
    if (seen) photograph_init(&t->photograph, job->plan, job->photograph);
    const struct path_context parts = {.queries = &t->queries,
                                       .light_kernels = KERNELS_FOR(light_kernels, scene->isa),
                                       .kernels = KERNELS_FOR(path_kernels, scene->isa),
                                       .lights = &t->lights,
                                       .sky = &t->sky,
                                       .plan = job->plan,
                                       .photograph = seen ? &t->photograph : NULL,
                                       .counters = job->counters};
    t->point.kernels = parts.light_kernels;
    stages_init(&parts, &t->centres, job->pass, stages);
}

/* Finds where lobes, or virtual objects, lie on the screen, if others need no paths. A lens or a
 * shutter blurs objects over the pixels around them; of sub-samples zero is no miss, and what
 * misses is open. */
static void find_boxes(struct tile_tracer *t, const struct stages *stages,
                       const struct tile_job *job)
{
    const struct plan *plan = job->plan;
    const struct render_scene *scene = job->scene;
    t->objects_only = t->queries.view == query_view_of(PLAN_VIEW_OBJECTS) && scene->virtuals &&
                      plan->camera.aperture_radius == 0.0f && !plan_has_shutter(plan) &&
                      !(plan->planes & (PLANE_BIT(SUB_DEPTH) | PLANE_BIT(PATH_VISIBILITY)));
    if (t->objects_only || stages->skips_paths)
        lobe_view_init(t->objects_only ? scene->virtuals : scene->lobes, plan, job->rect,
                       &t->lobes);
}

static int trace_stages(struct tile_tracer *t, const struct tile_job *job, struct samples *samples)
{
    struct stages stages;
    int e = 0;
    const struct sky_guide *guide = NULL;
    if (job->plan->environment.kind == ENVIRONMENT_MAP) {
        guide = sky_guides_take(job->scene->guides, job->environment, &job->plan->environment);
        if (!guide) return ERR_MEMORY;
    }
    prepare(t, job, guide, &stages);
    find_boxes(t, &stages, job);
    if (stages.lens) lens_scratch_init(&t->lens, job->plan);
    if (stages.through_lens.centres) e = centre_gbuffer_init(&t->centres, &stages.field, job->rect);
    stages.field.progress = stages.through_lens.progress = stages.whole.progress = job->progress;
    stages.field.stop = stages.through_lens.stop = stages.whole.stop = job->stop;
    if (e == 0) e = trace_rows(t, &stages, job, samples);
    if (e == 0) e = trace_borders(t, &stages, job->rect, samples);
    if (e == 0 && stages.count > 0) e = tile_trace_paths(t, &stages, job, samples);
    if (e == 0) e = trace_mattes(t, &stages, job, samples);
    if (stages.through_lens.centres) centre_gbuffer_fini(&t->centres);
    sky_guides_give(job->scene->guides, guide);
    return e;
}

/* Traces a pass that has been checked, of a plan with one view. */
static int trace_pass(struct tile_tracer *tracer, const struct tile_job *job, struct samples **out)
{
    struct samples *samples = NULL;
    int e = create_samples(job, &samples);
    if (e) return e;
    geometry_planes_init(&tracer->planes, samples);
    const uint64_t started_us = thread_cpu_us();
    const unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    e = trace_stages(tracer, job, samples);
    _mm_setcsr(mode);
    job->counters->value[COUNTER_REJECTED_NOT_FINITE] += tracer->queries.rejected;
    job->counters->value[COUNTER_TRACE_CPU_US] += thread_cpu_us() - started_us;
    if (e) samples_destroy(&samples);
    *out = samples;
    return e;
}

/* A pass of one of several views is traced as that of a plan of its own. */
static int trace_view(struct tile_tracer *tracer, const struct tile_job *job, struct samples **out)
{
    const struct plan one = plan_of_view(job->plan);
    const uint32_t views = plan_views(job->plan);
    struct plan_pass pass = *job->pass;
    struct tile_job of_view = *job;
    tracer->queries.view = query_view_of((enum plan_view)(pass.number % views));
    pass.number /= views;
    of_view.plan = &one;
    of_view.pass = &pass;
    const int e = trace_pass(tracer, &of_view, out);
    tracer->queries.view = NULL;
    return e;
}

int tile_trace_pass(struct tile_tracer *tracer, const struct tile_job *job, struct samples **out)
{
    const int e = check_job(job);
    if (e) return e;
    return plan_views(job->plan) > 1 ? trace_view(tracer, job, out) : trace_pass(tracer, job, out);
}

int tile_trace(struct tile_tracer *tracer, const struct tile_job *job, uint32_t pass,
               struct samples **out)
{
    if (pass >= plan_pass_count(job->plan)) return ERR_RANGE;
    const struct plan_pass scheduled = plan_scheduled_pass(job->plan, pass);
    struct tile_job of_pass = *job;
    of_pass.pass = &scheduled;
    return tile_trace_pass(tracer, &of_pass, out);
}
