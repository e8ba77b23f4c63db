#include "worker/trace/field/lone.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/path/path_leave.h"

#define INVERSE_PI 0.318309886183790672f

_Static_assert(LONE_ROWS *(LIMIT_SUB_SAMPLES + 1) <= 65536, "rows that curves tell apart");

/* What the shading of a tile's lone sub-samples shares. */
struct shading {
    struct path_context context; /* with the plan of one sub-sample, and counters of its own */
    const struct plan *plan;     /* the frame's */
    const struct lone_tools *tools;
    struct lone_scratch *scratch;
    uint32_t parts;
};

void lone_scratch_init(struct lone_scratch *s)
{
    memset(s, 0, sizeof *s);
    queries_init_rays(&s->camera);
}

void lone_scratch_fini(struct lone_scratch *s)
{
    free(s->shaded);
    s->shaded = NULL;
    s->capacity = 0;
}

/* Plans the samples of one sub-sample. Only means are needed, because no filter reads more. */
static void plan_one(const struct plan *plan, uint32_t parts, struct plan *out)
{
    const bool half = parts >> LONE_INDIRECT_HALF & 1u;
    *out = *plan;
    out->shadow_filter = SHADOW_FILTER_NONE;
    out->indirect_filter = INDIRECT_FILTER_NONE;
    out->light_planes = parts >> LONE_DIRECT & 1u ? 1u << LIGHT_PLANE_IRRADIANCE : 0;
    out->planes = 0;
    if (parts >> LONE_INDIRECT & 1u)
        out->planes |= PLANE_BIT(INDIRECT_MEAN) | (half ? PLANE_BIT(INDIRECT_HALVES) : 0);
    if (parts >> LONE_GLOSSY & 1u) out->planes |= PLANE_BIT(GLOSSY_MEAN);
    if (parts >> LONE_GLOSSY_HALF & 1u) out->planes |= PLANE_BIT(GLOSSY_HALF);
}

static int reserve(struct lone_scratch *s, uint32_t more)
{
    if (s->capacity - s->count >= more) return 0;
    const uint32_t capacity = 2 * s->capacity > s->count + more ? 2 * s->capacity : s->count + more;
    struct lone_shaded *shaded = realloc(s->shaded, capacity * sizeof *shaded);
    if (!shaded) return ERR_MEMORY;
    s->shaded = shaded;
    s->capacity = capacity;
    return 0;
}

/* -- light -- */

/* Finds the lone lanes whose surface reflects something diffusely. */
static void find_diffuse(const struct lone_scratch *s, struct lanes_mask *lit)
{
    const struct surface *f = &s->vertex.surface;
    for (int i = 0; i < LANES; i++)
        lit->on[i] = s->block.kept.on[i] & f->hit.on[i] &
                     -((f->albedo.x[i] >= ALBEDO_BLACK) | (f->albedo.y[i] >= ALBEDO_BLACK) |
                       (f->albedo.z[i] >= ALBEDO_BLACK));
}

static void trace_lights(const struct shading *l, const struct lanes_mask *lit)
{
    struct lone_scratch *s = l->scratch;
    const struct path_context *c = &l->context;
    struct shading_point *p = &s->point;
    *p = (struct shading_point){.kernels = c->light_kernels,
                                .plan = &s->plan,
                                .block = &s->block,
                                .surface = &s->vertex.surface,
                                .lit = *lit,
                                .counted = *lit,
                                .lit_count = lanes_count(lit)};
    if (l->plan->paths.without_diffuse_direct) shading_point_see(c->kernels, &s->vertex, p);
    for (uint32_t k = 0; k < s->plan.light_count && p->lit_count > 0; k++)
        shadow_trace(c->queries, &c->lights->lights[k], k, p, l->tools->shadow, s->samples,
                     c->counters);
}

static void trace_lobes(const struct shading *l)
{
    struct lone_scratch *s = l->scratch;
    struct glossy_scratch *g = l->tools->glossy;
    glossy_lobes_find(&s->vertex, &g->lobes);
    for (int i = 0; i < LANES; i++) g->lobes.on.on[i] &= s->block.kept.on[i];
    if (lanes_count(&g->lobes.on) > 0)
        glossy_trace(&l->context, &s->block, &s->vertex, NULL, g, l->tools->paths, s->samples);
}

/* Traces the light of the block's lone lanes into the planes of s->samples, whose elements lanes
 * are. */
static void trace_light(const struct shading *l)
{
    struct lone_scratch *s = l->scratch;
    struct bounce_lanes lanes = {0};
    memset(s->samples->data, 0, s->samples->layout.total_bytes);
    find_diffuse(s, &lanes.lit);
    if (l->parts >> LONE_DIRECT & 1u) trace_lights(l, &lanes.lit);
    if ((l->parts >> LONE_INDIRECT & 1u) && lanes_count(&lanes.lit) > 0)
        indirect_trace(&l->context, &s->block, &s->vertex, &lanes, NULL, l->tools->indirect,
                       l->tools->paths, s->samples);
    if (l->parts >> LONE_GLOSSY & 1u) trace_lobes(l);
}

/* -- what an entry holds -- */

static float cut(float radiance)
{
    return radiance < LONE_RADIANCE_MAX ? radiance : LONE_RADIANCE_MAX;
}

static void take_direct(const struct shading *l, int lane, float out[3])
{
    const struct plan *plan = &l->scratch->plan;
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const float e = samples_light_irradiance(l->scratch->samples, k)[lane];
        for (int c = 0; c < 3; c++)
            out[c] = cut(out[c] + cut(plan->lights[k].color[c] * INVERSE_PI * e));
    }
}

/* Reads the first three components of a plane of half floats, with the scale taken out. */
static void take_halves(const struct shading *l, enum plane_id plane, int lane, float out[3])
{
    const float scale = 1.0f / l->plan->radiance_scale; /* a positive power of two */
    for (uint32_t c = 0; c < 3; c++)
        out[c] = cut(half_to_float(samples_u16(l->scratch->samples, plane, c)[lane]) * scale);
}

/* Takes the means of all bounce rays, and of the even ones. */
static void take_indirect(const struct shading *l, int lane, float light[LONE_PART_COUNT][3])
{
    take_halves(l, PLANE_INDIRECT_MEAN, lane, light[LONE_INDIRECT]);
    if (l->parts >> LONE_INDIRECT_HALF & 1u)
        take_halves(l, PLANE_INDIRECT_HALVES, lane, light[LONE_INDIRECT_HALF]);
}

static void take(const struct shading *l, uint32_t place, int lane, struct lone_shaded *out)
{
    memset(out, 0, sizeof *out);
    out->place = place;
    if (l->parts >> LONE_DIRECT & 1u) take_direct(l, lane, out->light[LONE_DIRECT]);
    if (l->parts >> LONE_INDIRECT & 1u) take_indirect(l, lane, out->light);
    if (l->parts >> LONE_GLOSSY & 1u)
        take_halves(l, PLANE_GLOSSY_MEAN, lane, out->light[LONE_GLOSSY]);
    if (l->parts >> LONE_GLOSSY_HALF & 1u)
        take_halves(l, PLANE_GLOSSY_HALF, lane, out->light[LONE_GLOSSY_HALF]);
}

/* -- those at hand -- */

static void take3(const struct lanes3 *from, int i, struct lanes3 *to, uint32_t n)
{
    to->x[n] = from->x[i];
    to->y[n] = from->y[i];
    to->z[n] = from->z[i];
}

static void take_surface(const struct surface *from, int i, struct surface *to, uint32_t n)
{
    take3(&from->position, i, &to->position, n);
    take3(&from->origin, i, &to->origin, n);
    take3(&from->plane, i, &to->plane, n);
    take3(&from->lift, i, &to->lift, n);
    take3(&from->facet, i, &to->facet, n);
    take3(&from->normal, i, &to->normal, n);
    take3(&from->albedo, i, &to->albedo, n);
    take3(&from->emission, i, &to->emission, n);
    to->distance[n] = from->distance[i];
    to->id[n] = from->id[i];
    to->hit.on[n] = from->hit.on[i];
    to->light.on[n] = from->light.on[i];
    to->behind.on[n] = from->behind.on[i];
    to->mesh[n] = from->mesh[i];
}

/* Copies lane i of what was met to lane n of those at hand. */
static void take_lane(const struct path_vertex *from, int i, struct path_vertex *to, uint32_t n)
{
    take_surface(&from->surface, i, &to->surface, n);
    to->active.on[n] = from->active.on[i];
    to->lambert.on[n] = from->lambert.on[i];
    if (from->lambert.on[i]) return;
    to->bsdf[n] = from->bsdf[i];
    take3(&from->tangent, i, &to->tangent, n);
    take3(&from->bitangent, i, &to->bitangent, n);
    take3(&from->back, i, &to->back, n);
}

/* Lanes that hold none are off. */
static void close_lanes(struct lone_scratch *s)
{
    struct path_vertex *v = &s->vertex;
    v->any_lambert = v->any_general = v->mirrors.any = false;
    s->block.whole = false;
    for (uint32_t i = 0; i < LANES; i++) {
        const int32_t on = i < s->held ? -1 : 0;
        s->block.inside.on[i] = s->block.kept.on[i] = on;
        s->block.element[i] = i;
        v->active.on[i] &= on;
        v->lambert.on[i] &= on;
        v->surface.hit.on[i] &= on;
        v->any_lambert |= v->lambert.on[i] != 0;
        v->any_general |= v->active.on[i] != v->lambert.on[i];
    }
}

/* Counts progress as rows of pixels do. All of a tile's rows are counted by now. */
static void tell_progress(const struct shading *l)
{
    _Atomic uint64_t *progress = l->context.progress;
    if (progress) atomic_fetch_add_explicit(progress, 1, memory_order_relaxed);
}

static void shade(const struct shading *l)
{
    struct lone_scratch *s = l->scratch;
    if (s->held == 0) return;
    close_lanes(s);
    trace_light(l);
    for (uint32_t i = 0; i < s->held; i++) take(l, s->place[i], (int)i, &s->shaded[s->count++]);
    s->held = 0;
    tell_progress(l);
}

/* -- a tile's -- */

/* Adds sub-samples k of the lanes in *lone. The block's rays are traced once more, all of them:
 * where two triangles lie at one distance, rays beside decide which one is met. */
static void add_subs(const struct shading *l, const struct block *b, uint32_t k,
                     const struct lanes_mask *lone)
{
    struct lone_scratch *s = l->scratch;
    const struct path_context *c = &l->context;
    primary_trace_sub(c->queries, l->plan, b, k, l->plan->sub_samples, &s->camera, &s->met.surface);
    c->counters->value[COUNTER_RAYS_PRIMARY] += lanes_count(&b->inside);
    s->met.active = s->met.surface.hit;
    s->met.mirrors.any = false;
    path_resolve(c, &s->camera, &s->met);
    if (l->plan->paths.without_diffuse_direct) path_hide_from_fields(&s->met.surface);
    for (int i = 0; i < LANES; i++) {
        if (!lone->on[i]) continue;
        s->place[s->held] = b->element[i] * l->plan->sub_samples + k;
        s->block.x_px[s->held] = b->x_px[i];
        s->block.y_px[s->held] = b->y_px[i] + (int32_t)(k + 1) * LONE_ROWS;
        take_lane(&s->met, i, &s->vertex, s->held);
        if (++s->held == LANES) shade(l);
    }
}

static int trace_block(const struct shading *l, int32_t x, int32_t y, struct rect tile)
{
    struct lone_scratch *s = l->scratch;
    struct lanes_mask lone[LIMIT_SUB_SAMPLES];
    struct block b;
    block_init(&b, x, y, l->plan->width_px, l->plan->height_px, tile);
    const uint32_t count = lone_finder_look(&s->finder, &b, lone);
    if (count == 0) return 0;
    const int error = reserve(s, count + LANES);
    if (error) return error;
    for (uint32_t k = 0; k < l->plan->sub_samples; k++)
        if (lanes_count(&lone[k]) > 0) add_subs(l, &b, k, &lone[k]);
    return 0;
}

static bool is_stopped(const struct path_context *c)
{
    return c->stop && atomic_load_explicit(c->stop, memory_order_relaxed);
}

static int trace_square(const struct shading *l, struct rect square, struct rect tile)
{
    const struct rect r = rect_intersect(square, tile);
    int error = 0;
    for (int32_t y = r.y0 & -LANES_ACROSS; y < r.y1 && !error; y += LANES_ACROSS)
        for (int32_t x = r.x0 & -LANES_ACROSS; x < r.x1 && !error; x += LANES_ACROSS)
            error = trace_block(l, x, y, tile);
    if (error) return error;
    shade(l);
    return is_stopped(&l->context) ? ERR_STATE : 0;
}

static int trace_squares(const struct shading *l, struct rect tile)
{
    const int32_t side = LONE_SIDE_PX;
    int error = 0;
    for (int32_t y = tile.y0 & -side; y < tile.y1 && !error; y += side)
        for (int32_t x = tile.x0 & -side; x < tile.x1 && !error; x += side)
            error = trace_square(l, (struct rect){x, y, x + side, y + side}, tile);
    return error;
}

static int compare(const void *a, const void *b)
{
    const uint32_t x = ((const struct lone_shaded *)a)->place;
    const uint32_t y = ((const struct lone_shaded *)b)->place;
    return (x > y) - (x < y);
}

/* Lists the shaded sub-samples in the order of their places. */
static int make_list(const struct shading *l, struct samples *samples)
{
    struct lone_scratch *s = l->scratch;
    struct sparse_list *list;
    if (s->count == 0) return 0;
    if (lone_create(l->parts, s->count, &list) != 0) return ERR_MEMORY;
    qsort(s->shaded, s->count, sizeof *s->shaded, compare);
    for (uint32_t e = 0; e < s->count; e++) list->words[e] = s->shaded[e].place;
    for (uint32_t part = 0; part < LONE_PART_COUNT; part++)
        for (uint32_t c = 0; c < 3; c++) {
            float *out = lone_values(list, part, c);
            for (uint32_t e = 0; out && e < s->count; e++) out[e] = s->shaded[e].light[part][c];
        }
    samples->lone = list;
    return 0;
}

static void count_rays(const struct counters *own, struct counters *all)
{
    const uint64_t *v = own->value;
    all->value[COUNTER_RAYS_LONE] += v[COUNTER_RAYS_PRIMARY] + v[COUNTER_RAYS_SHADOW] +
                                     v[COUNTER_RAYS_INDIRECT] + v[COUNTER_RAYS_INDIRECT_SHADOW];
    all->value[COUNTER_REJECTED_NOT_FINITE] += v[COUNTER_REJECTED_NOT_FINITE];
}

/* Fields at half resolution have as many rays a pixel in the mean. */
static uint32_t lone_strata(const struct path_context *c)
{
    return c->plan->field_halved ? (c->strata + 1) / 2 : c->strata;
}

int lone_trace(const struct path_context *c, const struct lone_tools *tools, struct rect tile,
               struct lone_scratch *scratch, struct samples *samples)
{
    struct samples_layout layout;
    struct shading l = {.context = *c,
                        .plan = c->plan,
                        .tools = tools,
                        .scratch = scratch,
                        .parts = samples->layout.lone_parts};
    plan_one(c->plan, l.parts, &scratch->plan);
    int error = samples_layout_init(&layout, &scratch->plan, 0, LANES, 1);
    if (!error) error = samples_create(&layout, &scratch->samples);
    if (error) return error;
    memset(&scratch->counters, 0, sizeof scratch->counters);
    scratch->count = scratch->held = 0;
    l.context.counters = &scratch->counters;
    l.context.strata = lone_strata(c);
    struct path_context centres = l.context; /* with the frame's plan */
    l.context.plan = &scratch->plan;
    lone_finder_init(&scratch->finder, &centres, tile, samples);
    error = trace_squares(&l, tile);
    if (!error) error = make_list(&l, samples);
    count_rays(&scratch->counters, c->counters);
    samples_destroy(&scratch->samples);
    return error;
}

void lone_settle(const struct path_context *c, struct rect tile, struct lone_scratch *scratch,
                 struct samples *samples)
{
    if ((samples->layout.planes & PLANES_CENTRE) != PLANES_CENTRE) return;
    lone_finder_init(&scratch->finder, c, tile, samples);
    if ((samples->layout.planes & PLANES_COMPARED) != PLANES_COMPARED) return;
    for (int32_t y = tile.y0 & -LANES_ACROSS; y < tile.y1; y += LANES_ACROSS)
        for (int32_t x = tile.x0 & -LANES_ACROSS; x < tile.x1; x += LANES_ACROSS) {
            struct block b;
            block_init(&b, x, y, c->plan->width_px, c->plan->height_px, tile);
            lone_finder_settle(&scratch->finder, &b);
        }
}
