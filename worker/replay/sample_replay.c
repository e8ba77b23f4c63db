#include "worker/replay/sample_replay.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "proto/pattern_path.h"
#include "worker/scene/emitters.h"
#include "worker/tile/stages.h"
#include "worker/trace/field/edge_pixels.h"
#include "worker/trace/field/lens.h"
#include "worker/trace/field/lens_second_set.h"
#include "worker/trace/field/lens_surface.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/centre_gbuffer.h"
#include "worker/trace/path/path_kernels.h"

/* Denormals are flushed, as when tiles are traced. */
#define MXCSR_FLUSH 0x8040u

struct replay {
    struct queries queries;
    struct light_table lights;
    struct sky sky;
    struct counters counters;
    struct path_scratch path;
    struct lens_scratch lens;
    struct centre_gbuffer centres;
    struct lone_finder lone;
    struct mixed_finder finder;
    size_t slot; /* of the pixel in its block */
};

/* Finds the kind of a sample from its number, and how many there are of that kind. */
static void find_kind(const struct plan *plan, uint32_t sample, struct path_record *record)
{
    const uint32_t most = plan->spp_max > plan->paths.spp ? plan->spp_max : plan->paths.spp;
    const uint32_t l = plan->lens_strata_per_axis;
    record->kind = PATH_RECORD_PATHS;
    record->last = (most << plan->paths.edge_digits) - 1;
    if (plan->paths.spp > 0) return;
    record->kind = PATH_RECORD_LENS;
    record->last = l * l - 1;
    if (plan->lens_extra == 0 || sample < LENS_SECOND_SET_FIRST) return;
    record->kind = PATH_RECORD_LENS_SECOND_SET;
    record->first = LENS_SECOND_SET_FIRST;
    record->last = LENS_SECOND_SET_FIRST + PLAN_LENS_EXTRA_STRATA * PLAN_LENS_EXTRA_STRATA - 1;
}

static int check_sample(uint32_t sample, const struct path_record *record, struct fault *fault)
{
    if (sample >= record->first && sample <= record->last) return 0;
    return fault_set(fault, ERR_RANGE, "sample", "%u: the pixel has samples %u to %u", sample,
                     record->first, record->last);
}

static int check(const struct plan *plan, const struct environment *environment, int32_t x,
                 int32_t y, uint32_t sample, const struct path_record *record, struct fault *fault)
{
    if (plan->paths.spp == 0 && plan->lens_strata_per_axis == 0)
        return fault_set(fault, ERR_UNSUPPORTED, "",
                         "the plan has no paths: light fields make its picture; filter.method "
                         "\"none\" asks for paths");
    if (x < 0 || y < 0 || x >= plan->width_px || y >= plan->height_px)
        return fault_set(fault, ERR_RANGE, "pixel", "%d,%d is outside the image of %dx%d", x, y,
                         plan->width_px, plan->height_px);
    if (check_sample(sample, record, fault)) return ERR_RANGE;
    if (plan->environment.kind == ENVIRONMENT_MAP && !environment)
        return fault_set(fault, ERR_MISSING, "environment", "the plan has a map");
    return 0;
}

static void take(const struct path_rgb *from, size_t slot, float out[3])
{
    out[0] = from->r[slot];
    out[1] = from->g[slot];
    out[2] = from->b[slot];
}

/* Adds a sample up as path_sums.c does, and refuses numbers that are not finite. */
static void sum_up(const struct path_radiance *h, size_t slot, struct path_record *out)
{
    float white[2][3];
    take(&h->emission, slot, out->emission);
    take(&h->direct, slot, out->direct);
    take(&h->indirect, slot, out->indirect);
    take(&h->diffuse_direct, slot, white[0]);
    take(&h->diffuse_indirect, slot, white[1]);
    for (int k = 0; k < 3; k++) {
        const float parts[5] = {out->emission[k], out->direct[k], out->indirect[k], white[0][k],
                                white[1][k]};
        for (int i = 0; i < 5; i++) out->rejected |= !(parts[i] < INFINITY);
        out->radiance[k] = parts[0] + parts[1] + parts[2];
    }
    if (out->rejected) memset(out->radiance, 0, sizeof out->radiance);
}

/* Finds the position of a path. Lens samples of light fields have numbers of their pixel. */
static void find_position(const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                          uint32_t edge_digits, enum path_record_kind kind, float pixel[2])
{
    const struct pattern *p = &plan->pattern;
    const struct path_places places =
        path_edge_places_of(p->seed, p->frame, x, y, plan->paths.spp, edge_digits);
    float u, v;
    if (kind == PATH_RECORD_PATHS)
        path_pair(path_place_key(places, sample), path_place_sample(places, sample), PATH_PIXEL, &u,
                  &v);
    else
        path_pair(path_key(p->seed, p->frame, x, y), sample, PATH_PIXEL, &u, &v);
    pixel[0] = (float)x + path_pixel_offset(plan, u);
    pixel[1] = (float)y + path_pixel_offset(plan, v);
}

/* Adds a lens sample up. It travels by itself, without the light of fields. */
static void sum_up_lens(const struct path_context *c, struct path_radiance *h, size_t slot,
                        struct path_record *out)
{
    float e[3], d[3], n[3], sum[3];
    if (c->plan->lens_relight != LENS_RELIGHT_OWN && out->kind == PATH_RECORD_LENS)
        lens_surface_take_out(c, slot, h);
    take(&h->emission, slot, e);
    take(&h->direct, slot, d);
    take(&h->indirect, slot, n);
    for (int k = 0; k < 3; k++) sum[k] = e[k] + d[k] + n[k];
    out->rejected = !(sum[0] < INFINITY && sum[1] < INFINITY && sum[2] < INFINITY);
    for (int k = 0; k < 3; k++)
        out->stored[k] = out->rejected ? 0.0f : fminf(sum[k], LENS_RADIANCE_MAX);
}

/* Returns the context with which the sample is traced. */
static const struct path_context *context_of(const struct stages *stages,
                                             enum path_record_kind kind)
{
    if (kind == PATH_RECORD_LENS) return &stages->through_lens;
    return kind == PATH_RECORD_PATHS ? &stages->paths : &stages->whole;
}

static int trace_path(struct replay *t, struct stages *stages, const struct block *block,
                      uint32_t sample, const struct path_record *record)
{
    const struct path_context *c = context_of(stages, record->kind);
    const struct rect pixel = {block->x_px[t->slot], block->y_px[t->slot], block->x_px[t->slot] + 1,
                               block->y_px[t->slot] + 1};
    if (record->kind != PATH_RECORD_LENS) {
        path_trace(c, block, sample, 1, &t->path);
        return 0;
    }
    const int e = c->centres ? centre_gbuffer_init(&t->centres, &stages->field, pixel) : 0;
    if (e) return e;
    lens_scratch_init(&t->lens, c->plan);
    lens_begin(c, block, sample, &t->lens, &t->path.pools[0]);
    path_trace_camera(c, &t->path);
    if (c->centres) centre_gbuffer_fini(&t->centres);
    return 0;
}

/* Finds whether the pixel is at an edge: others have no more than the plan's paths. */
static int find_edge(struct replay *t, int32_t x, int32_t y, struct path_context *paths,
                     struct path_record *record)
{
    const struct rect pixel = {x, y, x + 1, y + 1};
    const uint32_t more = paths->plan->paths.edge_digits;
    if (more == 0) return 0;
    const int error = edge_pixels_find(paths, pixel, &t->lone, &t->finder);
    const bool edge = !error && t->finder.edge[0];
    mixed_finder_fini(&t->finder);
    if (edge)
        paths->edge_digits = more;
    else
        record->last = (record->last + 1) / (1u << more) - 1;
    return error;
}

static int trace(struct replay *t, const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                 struct path_record *record, struct fault *fault)
{
    const struct plan_pass pass = plan_scheduled_pass(plan, 0);
    const struct path_context parts = {.queries = &t->queries,
                                       .light_kernels =
                                           KERNELS_FOR(light_kernels, t->queries.scene->isa),
                                       .kernels = KERNELS_FOR(path_kernels, t->queries.scene->isa),
                                       .lights = &t->lights,
                                       .sky = &t->sky,
                                       .plan = plan,
                                       .counters = &t->counters};
    struct stages stages;
    struct block block;
    stages_init(&parts, &t->centres, &pass, &stages);
    int e = find_edge(t, x, y, &stages.paths, record);
    if (!e) e = check_sample(sample, record, fault);
    if (e) return e;
    find_position(plan, x, y, sample, stages.paths.edge_digits, record->kind, record->pixel);
    stages.paths.record = stages.through_lens.record = stages.whole.record = record;
    block_init(&block, x & -LANES_ACROSS, y & -LANES_ACROSS, plan->width_px, plan->height_px,
               (struct rect){x, y, x + 1, y + 1});
    while (!block.kept.on[t->slot]) t->slot++;
    e = trace_path(t, &stages, &block, sample, record);
    if (e) return e;
    sum_up(&t->path.radiance, t->slot, record);
    memcpy(record->stored, record->radiance, sizeof record->stored);
    if (record->kind != PATH_RECORD_PATHS)
        sum_up_lens(context_of(&stages, record->kind), &t->path.radiance, t->slot, record);
    return 0;
}

int sample_replay(const struct render_scene *scene, const struct environment *environment,
                  const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                  struct path_record *record, struct fault *fault)
{
    memset(record, 0, sizeof *record);
    find_kind(plan, sample, record);
    int e = check(plan, environment, x, y, sample, record, fault);
    if (e) return e;
    struct replay *t = aligned_alloc(LANES_ALIGN, sizeof *t);
    if (!t) return fault_set(fault, ERR_MEMORY, "", "%s", error_text(ERR_MEMORY));
    memset(t, 0, sizeof *t);
    queries_init(&t->queries);
    path_scratch_init(&t->path);
    t->queries.scene = scene;
    t->queries.kernels = KERNELS_FOR(hit_kernels, scene->isa);
    const unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    light_table_init(&t->lights, plan, emitters_tree(scene->emitters));
    const bool has_map = plan->environment.kind == ENVIRONMENT_MAP;
    const struct sky_guide *guide =
        has_map ? sky_guides_take(scene->guides, environment, &plan->environment) : NULL;
    sky_init(&t->sky, &plan->environment, environment, guide);
    e = has_map && !guide ? ERR_MEMORY : trace(t, plan, x, y, sample, record, fault);
    sky_guides_give(scene->guides, guide);
    _mm_setcsr(mode);
    free(t);
    return e && e != ERR_RANGE ? fault_set(fault, e, "", "%s", error_text(e)) : e;
}
