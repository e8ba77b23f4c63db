#include "worker/tile/tile.h"

#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "proto/runtime/clock.h"
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
    *out = t;
    return 0;
}

void tile_tracer_destroy(struct tile_tracer **tracer)
{
    if (*tracer) lone_scratch_fini(&(*tracer)->lone);
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

/* Blocks from (x, y) on, at most PRIMARY_ROW, up to the tile's end. */
static int trace_blocks(struct tile_tracer *t, const struct stages *stages, const struct plan *plan,
                        int32_t x, int32_t y, struct rect rect, const _Atomic bool *stop,
                        struct samples *samples, struct counters *counters)
{
    const int32_t left = (rect.x1 - x + LANES_ACROSS - 1) / LANES_ACROSS;
    const int32_t count = left < PRIMARY_ROW ? left : PRIMARY_ROW;
    if (tile_sees_centres(stages))
        primary_trace_row(&t->queries, plan, x, y, (uint32_t)count, t->row);
    for (int32_t k = 0; k < count; k++, x += LANES_ACROSS) {
        block_init(&t->block, x, y, plan->width_px, plan->height_px, rect);
        tile_trace_block(t, stages, plan, &t->row[k], samples, counters);
        if (is_stopped(stop)) return ERR_STATE;
    }
    return 0;
}

static int trace_rows(struct tile_tracer *t, const struct stages *stages, const struct plan *plan,
                      struct rect rect, _Atomic uint64_t *progress, const _Atomic bool *stop,
                      struct samples *samples, struct counters *counters)
{
    for (int32_t y = rect.y0 & -LANES_ACROSS; y < rect.y1; y += LANES_ACROSS) {
        for (int32_t x = rect.x0 & -LANES_ACROSS; x < rect.x1; x += PRIMARY_ROW * LANES_ACROSS)
            if (trace_blocks(t, stages, plan, x, y, rect, stop, samples, counters))
                return ERR_STATE;
        int32_t first = y > rect.y0 ? y : rect.y0;
        int32_t end = y + LANES_ACROSS < rect.y1 ? y + LANES_ACROSS : rect.y1;
        if (progress)
            atomic_fetch_add_explicit(progress, (uint64_t)(end - first), memory_order_relaxed);
    }
    return 0;
}

/* When all planes are there: sub-samples that none of the pixels around them shows. */
static int trace_lone(struct tile_tracer *t, const struct stages *stages, struct rect rect,
                      struct samples *samples)
{
    const struct lone_tools tools = {&t->shadow, &t->indirect, &t->glossy, &t->path};
    if (samples->layout.lone_parts > 0)
        return lone_trace(&stages->field, &tools, rect, &t->lone, samples);
    lone_settle(&stages->field, rect, &t->lone, samples);
    return 0;
}

static bool rect_fits(const struct plan *plan, struct rect rect)
{
    return rect.x0 >= 0 && rect.y0 >= 0 && rect.x0 < rect.x1 && rect.y0 < rect.y1 &&
           rect.x1 <= plan->width_px && rect.y1 <= plan->height_px &&
           rect_width(rect) <= LIMIT_TILE_SIDE_PX && rect_height(rect) <= LIMIT_TILE_SIDE_PX;
}

int tile_trace_pass(struct tile_tracer *tracer, const struct render_scene *scene,
                    const struct environment *environment, const struct plan *plan,
                    const struct plan_pass *pass, struct rect rect, _Atomic uint64_t *progress,
                    const _Atomic bool *stop, struct samples **out, struct counters *counters)
{
    struct samples_layout layout;
    struct stages stages;
    struct samples *samples = NULL;
    int rc = rect_fits(plan, rect) ? plan_pass_check(plan, pass) : ERR_RANGE;
    if (rc) return rc;
    if (plan->environment.kind == ENVIRONMENT_MAP && !environment) return ERR_MISSING;
    if (pass->sides) rc = plan_sides_check(pass, (size_t)rect_area(rect));
    if (rc) return rc;
    rc = samples_layout_init(&layout, plan, pass->number, rect_width(rect), rect_height(rect));
    if (rc == 0) rc = samples_create(&layout, &samples);
    if (rc) return rc;
    geometry_planes_init(&tracer->planes, samples);
    uint64_t started_us = thread_cpu_us();
    unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    tracer->queries.scene = scene;
    tracer->queries.kernels = KERNELS_FOR(hit_kernels, scene->isa);
    tracer->queries.rejected = 0;
    light_table_init(&tracer->lights, plan, scene->emitters != NULL);
    sky_init(&tracer->sky, &plan->environment, environment);
    const struct path_context parts = {.queries = &tracer->queries,
                                       .light_kernels = KERNELS_FOR(light_kernels, scene->isa),
                                       .kernels = KERNELS_FOR(path_kernels, scene->isa),
                                       .lights = &tracer->lights,
                                       .sky = &tracer->sky,
                                       .plan = plan,
                                       .counters = counters};
    tracer->point.kernels = parts.light_kernels;
    stages_init(&parts, &tracer->centres, pass, &stages);
    if (stages.lens) lens_scratch_init(&tracer->lens, plan);
    if (stages.through_lens.centres)
        rc = centre_gbuffer_init(&tracer->centres, &stages.field, rect);
    stages.field.progress = stages.through_lens.progress = stages.whole.progress = progress;
    stages.field.stop = stages.through_lens.stop = stages.whole.stop = stop;
    if (rc == 0) rc = trace_rows(tracer, &stages, plan, rect, progress, stop, samples, counters);
    if (rc == 0) rc = trace_lone(tracer, &stages, rect, samples);
    if (stages.through_lens.centres) centre_gbuffer_fini(&tracer->centres);
    _mm_setcsr(mode);
    counters->value[COUNTER_REJECTED_NOT_FINITE] += tracer->queries.rejected;
    counters->value[COUNTER_TRACE_CPU_US] += thread_cpu_us() - started_us;
    if (rc) samples_destroy(&samples);
    *out = samples;
    return rc;
}

int tile_trace(struct tile_tracer *tracer, const struct render_scene *scene,
               const struct environment *environment, const struct plan *plan, uint32_t pass,
               struct rect rect, _Atomic uint64_t *progress, const _Atomic bool *stop,
               struct samples **out, struct counters *counters)
{
    if (pass >= plan_pass_count(plan)) return ERR_RANGE;
    const struct plan_pass scheduled = plan_scheduled_pass(plan, pass);
    return tile_trace_pass(tracer, scene, environment, plan, &scheduled, rect, progress, stop, out,
                           counters);
}
