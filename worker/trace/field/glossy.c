#include "worker/trace/field/glossy.h"

#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/shade/direction.h"
#include "worker/shade/glossy.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/path/path_kernels.h"

/* Darker lobes' light would not fit halves when divided by their reflectance. */
#define REFLECTANCE_MIN 1e-4f

/* Half floats end a little above; a mean of nearness may be anything. */
#define NEARNESS_MAX 65000.0f

/* Half of what floats hold. */
#define MOST 1e38f

/* What one block's rays share. */
struct gloss {
    const struct path_context *context;
    const struct block *block;
    const struct path_vertex *from;
    uint32_t most, rays[LANES];        /* rays of the lanes; the most */
    uint32_t first_half[LANES];        /* rays 0 .. first_half - 1 of each */
    uint32_t frame_key;                /* of the sequence of directions */
    struct lanes3 inverse;             /* 1 / reflectance */
    float whole[LANES];                /* 1 / its sum over channels */
    uint32_t key[LANES], first[LANES]; /* of later numbers; of the pixel's directions */
    struct lanes_mask on;
    struct lanes_mask later; /* lanes whose half is the second */
    struct layers layers;
    const struct field_pack *pack; /* of the lanes, which are its slots; or NULL */
};

static void store_unorms(const struct path_context *c, const struct block *b, const float *v,
                         uint16_t *plane)
{
    _Alignas(LANES_ALIGN) uint16_t packed[LANES];
    if (!plane) return;
    c->queries->kernels->pack_unorms(v, packed);
    block_store_u16(b, packed, plane);
}

static void store_reflectance(const struct path_context *c, const struct block *b,
                              const struct glossy_lobes *lobes, struct samples *samples,
                              enum plane_id plane, uint32_t first)
{
    store_unorms(c, b, lobes->reflectance.x, samples_u16(samples, plane, first));
    store_unorms(c, b, lobes->reflectance.y, samples_u16(samples, plane, first + 1));
    store_unorms(c, b, lobes->reflectance.z, samples_u16(samples, plane, first + 2));
}

static void store_lobes(const struct path_context *c, const struct block *b,
                        const struct glossy_lobes *lobes, struct samples *samples)
{
    store_reflectance(c, b, lobes, samples, PLANE_GLOSSY_LOBE, 0);
    store_unorms(c, b, lobes->alpha, samples_u16(samples, PLANE_GLOSSY_LOBE, 3));
}

/* Round lobes have no axes. */
static void store_axes(const struct path_context *c, const struct block *b,
                       const struct glossy_lobes *lobes, struct samples *samples)
{
    _Alignas(LANES_ALIGN) uint32_t packed[LANES];
    uint32_t *plane = samples_u32(samples, PLANE_GLOSSY_TANGENT, 0);
    store_unorms(c, b, lobes->stretch, samples_u16(samples, PLANE_GLOSSY_STRETCH, 0));
    if (!plane) return;
    c->queries->kernels->pack_normals(&lobes->tangent, 16, packed);
    for (int i = 0; i < LANES; i++) packed[i] = lobes->stretch[i] > 0.0f ? packed[i] : 0;
    block_store_u32(b, packed, plane);
}

void glossy_store_sub(const struct path_context *c, const struct block *b, uint32_t sub,
                      const struct glossy_lobes *lobes, struct samples *samples)
{
    store_reflectance(c, b, lobes, samples, PLANE_SUB_REFLECTANCE, 3 * sub);
}

static float inverse(float reflectance)
{
    return 1.0f / (reflectance > REFLECTANCE_MIN ? reflectance : REFLECTANCE_MIN);
}

static uint32_t rays_of(const struct path_context *c, const struct block *block, int i)
{
    if (!c->lobes) return c->strata * c->strata;
    const uint32_t l = block->kept.on[i] ? c->lobes[block->element[i]] : 0;
    return l * l;
}

static void gloss_init(const struct path_context *c, const struct block *block,
                       const struct path_vertex *from, const struct glossy_lobes *lobes,
                       struct gloss *g)
{
    const struct pattern pattern = path_pass_pattern(c), *p = &pattern;
    g->context = c;
    g->block = block;
    g->from = from;
    g->most = 0;
    g->pack = NULL;
    g->frame_key = path_frame_key(p->seed, p->frame);
    layers_see(c->kernels, from, &g->layers);
    for (int i = 0; i < LANES; i++) {
        const int32_t x = block->x_px[i], y = block->y_px[i];
        g->on.on[i] = lobes->on.on[i] & block->kept.on[i];
        g->rays[i] = rays_of(c, block, i);
        g->first_half[i] = (g->rays[i] + 1) / 2;
        g->later.on[i] = g->rays[i] > 1 && ((x + y) & 1) ? -1 : 0;
        if (g->on.on[i] && g->rays[i] > g->most) g->most = g->rays[i];
        g->key[i] = path_glossy_key(path_key(p->seed, p->frame, x, y));
        g->first[i] = path_morton(x, y) * g->rays[i]; /* may wrap: far away then comes the same */
        g->inverse.x[i] = inverse(lobes->reflectance.x[i]);
        g->inverse.y[i] = inverse(lobes->reflectance.y[i]);
        g->inverse.z[i] = inverse(lobes->reflectance.z[i]);
        g->whole[i] =
            inverse(lobes->reflectance.x[i] + lobes->reflectance.y[i] + lobes->reflectance.z[i]);
    }
}

/* Returns whether a sample is in lane i's half. Halves are runs of the sequence, which are as
 * evenly spread as all of it. Its even numbers would lie on one side of the lobe. */
static bool is_half(const struct gloss *g, uint32_t sample, int i)
{
    return (sample >= g->first_half[i]) == (g->later.on[i] != 0);
}

/* Adds sample `sample` of lane i to the pool, and its weight to the sums. */
static void begin_path(const struct gloss *g, const struct layer_gloss *lobe, uint32_t sample,
                       uint32_t slot, int i, struct glossy_sums *sums, struct path_pool *pool)
{
    const uint32_t lane = g->pack ? g->pack->lane[i] : (uint32_t)i;
    const struct lanes3 *w = &lobe->weight;
    /* By what each channel reflects: where one is nearly black, its own ratio is noise. */
    const float whole = (w->x[i] + w->y[i] + w->z[i]) * g->whole[i];
    const float weight[3] = {w->x[i] * g->inverse.x[i], w->y[i] * g->inverse.y[i],
                             w->z[i] * g->inverse.z[i]};
    sums->weight[lane] += whole;
    sums->half_weight[lane] += is_half(g, sample, i) ? whole : 0.0f;
    if (lobe->above.on[i])
        path_pool_begin(pool,
                        &(struct path_start){.surface = &g->from->surface,
                                             .direction = &lobe->direction,
                                             .weight = {weight[0], weight[1], weight[2]},
                                             .reach = INFINITY,
                                             .key = g->key[i],
                                             .sample = sample,
                                             .slot = slot},
                        i);
    else
        g->context->counters->value[COUNTER_SKIPPED_BOUNCE_BELOW_HORIZON]++;
}

/* Samples the lobes of lanes that are no layers, one by one. */
static void gloss_others(const struct gloss *g, const float *u, const float *w,
                         struct layer_gloss *out)
{
    const struct path_vertex *v = g->from;
    for (int i = 0; g->layers.others && i < LANES; i++) {
        const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]}, at[2] = {u[i], w[i]};
        float wi[3], d[3], weight[3];
        if (!g->on.on[i] || g->layers.on.on[i]) continue;
        out->on.on[i] = glossy_sample(&v->bsdf[i], wo, at, wi, weight) ? -1 : 0;
        if (!out->on.on[i]) continue;
        path_from_frame(v, i, wi, d);
        const struct surface *s = &v->surface;
        const float facing = d[0] * s->facet.x[i] + d[1] * s->facet.y[i] + d[2] * s->facet.z[i];
        out->above.on[i] = facing > 0.0f ? -1 : 0;
        out->weight.x[i] = weight[0], out->weight.y[i] = weight[1], out->weight.z[i] = weight[2];
        out->direction.x[i] = d[0], out->direction.y[i] = d[1], out->direction.z[i] = d[2];
    }
}

/* Begins a row of samples of all lanes, in slots from `slot` on. */
static void begin_row(const struct gloss *g, uint32_t row, uint32_t slot, struct glossy_sums *sums,
                      struct path_pool *pool)
{
    const struct path_kernels *kernels = g->context->kernels;
    _Alignas(LANES_ALIGN) float u[LANES], w[LANES];
    uint32_t index[LANES];
    struct layer_gloss lobe;
    for (int i = 0; i < LANES; i++) index[i] = g->first[i] + field_pack_sample(g->pack, row, i);
    kernels->frame_pairs(g->frame_key, index, PATH_DIRECTION, u, w);
    kernels->layers_gloss(g->from, &g->layers, u, w, &lobe);
    gloss_others(g, u, w, &lobe);
    for (int i = 0; i < LANES; i++) {
        const uint32_t sample = field_pack_sample(g->pack, row, i);
        if (!g->on.on[i] || sample >= g->rays[i]) continue;
        if (lobe.on.on[i]) begin_path(g, &lobe, sample, slot + (uint32_t)i, i, sums, pool);
    }
}

/* Samples that are not finite count as black. Nothing is negative. */
static void add_sample(const struct gloss *g, const struct field_sample *of, uint32_t sample,
                       struct glossy_sums *sums)
{
    uint64_t *rejected = &g->context->counters->value[COUNTER_REJECTED_NOT_FINITE];
    for (size_t i = 0; i < LANES; i++) {
        const float r = of->radiance.x[i], y = of->radiance.y[i], b = of->radiance.z[i];
        const float t = of->distance[i];
        const bool finite = (r < INFINITY) & (y < INFINITY) & (b < INFINITY);
        *rejected += !finite;
        const bool half = finite && is_half(g, sample, (int)i);
        sums->light.x[i] += finite ? r : 0.0f;
        sums->light.y[i] += finite ? y : 0.0f;
        sums->light.z[i] += finite ? b : 0.0f;
        sums->half.x[i] += half ? r : 0.0f;
        sums->half.y[i] += half ? y : 0.0f;
        sums->half.z[i] += half ? b : 0.0f;
        sums->traced[i] += t > 0.0f ? 1.0f : 0.0f;
        sums->nearness[i] += t > 0.0f ? 1.0f / t : 0.0f; /* of a miss 0 */
        sums->farthest[i] = (t < INFINITY) & (t > sums->farthest[i]) ? t : sums->farthest[i];
        sums->nearest[i] = (t > 0.0f) & (t < sums->nearest[i]) ? t : sums->nearest[i];
    }
}

/* Rows first .. first + count - 1 of `g`, whose lanes are those of `all` or some of them packed. */
static void trace_batch(const struct gloss *g, const struct gloss *all, uint32_t first,
                        uint32_t count, struct glossy_sums *sums, struct path_scratch *paths)
{
    const uint32_t replicas = field_pack_replicas(g->pack);
    struct path_pool *pool = &paths->pools[0];
    struct field_sample sample;
    pool->count = 0;
    path_radiance_clear_field(&paths->radiance, count);
    if (g->context->mirrors) path_radiance_mirrors(&paths->radiance, count, g->from);
    for (uint32_t k = 0; k < count; k++) begin_row(g, first + k, k * LANES, sums, pool);
    path_trace_field(g->context, paths);
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t part = 0; part < replicas; part++) {
            field_pack_take(g->pack, &paths->radiance, k * LANES, part, &sample);
            add_sample(all, &sample, (first + k) * replicas + part, sums);
        }
}

/* Means over the pixels' halves. */
static void store_half(const struct gloss *g, const struct glossy_sums *sums,
                       struct samples *samples)
{
    const float *const light[4] = {sums->half.x, sums->half.y, sums->half.z, sums->half_weight};
    _Alignas(LANES_ALIGN) float v[LANES];
    if (!samples_u16(samples, PLANE_GLOSSY_HALF, 0)) return;
    for (uint32_t c = 0; c < 4; c++) {
        const float scale = c < 3 ? g->context->plan->radiance_scale : 1.0f;
        for (int i = 0; i < LANES; i++) {
            const uint32_t n = g->later.on[i] ? g->rays[i] - g->first_half[i] : g->first_half[i];
            v[i] = fminf(light[c][i], MOST) / (float)(n > 0 ? n : 1);
        }
        block_store_half(g->block, v, scale, samples_u16(samples, PLANE_GLOSSY_HALF, c));
    }
}

static void store(const struct gloss *g, const struct glossy_sums *sums, struct samples *samples)
{
    const struct plan *plan = g->context->plan;
    const float *const light[3] = {sums->light.x, sums->light.y, sums->light.z};
    _Alignas(LANES_ALIGN) float v[LANES], share[LANES];
    for (int i = 0; i < LANES; i++) share[i] = 1.0f / (float)(g->rays[i] > 0 ? g->rays[i] : 1);
    for (uint32_t c = 0; c < 3; c++) {
        /* sums of finite samples may be infinite */
        for (int i = 0; i < LANES; i++) v[i] = fminf(light[c][i], MOST) * share[i];
        block_store_half(g->block, v, plan->radiance_scale,
                         samples_u16(samples, PLANE_GLOSSY_MEAN, c));
    }
    for (int i = 0; i < LANES; i++) v[i] = sums->weight[i] * share[i];
    block_store_half(g->block, v, 1.0f, samples_u16(samples, PLANE_GLOSSY_MEAN, 3));
    for (int i = 0; i < LANES; i++) {
        const float mean = sums->traced[i] > 0.0f ? sums->nearness[i] / sums->traced[i] : 0.0f;
        v[i] = fminf(mean * plan->length_unit, NEARNESS_MAX);
    }
    block_store_half(g->block, v, 1.0f, samples_u16(samples, PLANE_GLOSSY_NEARNESS, 0));
    store_half(g, sums, samples);
}

static void store_span(const struct gloss *g, const struct glossy_sums *sums,
                       struct samples *samples)
{
    const float scale = 1.0f / g->context->plan->length_unit;
    _Alignas(LANES_ALIGN) float near[LANES], far[LANES];
    for (int i = 0; i < LANES; i++) {
        const bool met = sums->nearest[i] < INFINITY, traced = g->on.on[i] && g->rays[i] > 0;
        near[i] = met      ? block_distance(scale * sums->nearest[i])
                  : traced ? BOUNCE_DISTANCE_NONE
                           : 0.0f;
        far[i] = met ? block_distance(scale * sums->farthest[i]) : 0.0f;
    }
    block_store_positive_half(g->block, near, 1.0f, samples_u16(samples, PLANE_GLOSSY_SPAN, 0));
    block_store_positive_half(g->block, far, 1.0f, samples_u16(samples, PLANE_GLOSSY_SPAN, 1));
}

/* Traces all samples of the lanes of `g`; false if the tile was stopped. */
static bool trace_on(const struct gloss *g, const struct gloss *all, struct glossy_sums *sums,
                     struct path_scratch *paths)
{
    const uint32_t rows = field_pack_rows(g->pack, g->most);
    for (uint32_t done = 0; done < rows;) {
        const uint32_t left = rows - done, n = left < PATH_SAMPLES ? left : PATH_SAMPLES;
        if (done > 0 && !path_goes_on(g->context)) return false;
        trace_batch(g, all, done, n, sums, paths);
        done += n;
    }
    return true;
}

/* Nodes have a run of the sequence each, which follow each other; others have numbers far away. */
static void deal_half(const struct block *block, struct gloss *g)
{
    for (int i = 0; i < LANES; i++) {
        const int32_t x = block->x_px[i], y = block->y_px[i];
        if (half_field_is_node(x, y))
            g->first[i] = path_morton(x >> 1, y >> 1) * g->rays[i];
        else
            g->first[i] += UINT32_MAX / 2;
        g->later.on[i] = g->rays[i] > 1 && half_field_part(x, y) ? -1 : 0;
    }
}

/* Traces some lanes of a block side by side, as few as they may be. */
static bool trace_packed(const struct gloss *all, const struct lanes_mask *lanes,
                         struct glossy_scratch *s, struct path_scratch *paths)
{
    const struct path_context *c = all->context;
    struct gloss g = {.context = c, .frame_key = all->frame_key, .pack = &s->pack};
    if (lanes_count(lanes) == 0) return true;
    field_pack_init(all->block, all->from, lanes, &s->pack);
    g.block = &s->pack.block;
    g.from = &s->pack.vertex;
    g.on = s->pack.on;
    g.most = c->strata * c->strata;
    for (int v = 0; v < LANES; v++) {
        const uint32_t i = s->pack.lane[v];
        g.rays[v] = all->rays[i];
        g.first_half[v] = all->first_half[i];
        g.later.on[v] = all->later.on[i];
        g.key[v] = all->key[i];
        g.first[v] = all->first[i];
        g.inverse.x[v] = all->inverse.x[i];
        g.inverse.y[v] = all->inverse.y[i];
        g.inverse.z[v] = all->inverse.z[i];
        g.whole[v] = all->whole[i];
    }
    layers_see(c->kernels, g.from, &g.layers);
    return trace_on(&g, all, &s->sums, paths);
}

/* Traces the lanes that nodes do not stand for. All others get no weight. */
static bool trace_half(struct gloss *g, struct half_field *half, struct glossy_scratch *s,
                       struct path_scratch *paths)
{
    const struct path_context *c = g->context;
    struct lanes_mask more;
    float nearness[LANES];
    half_field_init(g->block, &g->from->surface, &s->lobes.on, half);
    deal_half(g->block, g);
    if (!trace_packed(g, &half->traced, s, paths)) return false;
    for (int i = 0; i < LANES; i++)
        nearness[i] = s->sums.traced[i] > 0.0f ? s->sums.nearness[i] / s->sums.traced[i] : 0.0f;
    half_field_refine_lobes(&s->lobes, nearness, c->strata, half, &more, c->counters);
    g->on = half->traced;
    return trace_packed(g, &more, s, paths);
}

void glossy_trace(const struct path_context *c, const struct block *block,
                  const struct path_vertex *from, struct half_field *half,
                  struct glossy_scratch *scratch, struct path_scratch *paths,
                  struct samples *samples)
{
    struct gloss g;
    gloss_init(c, block, from, &scratch->lobes, &g);
    memset(&scratch->sums, 0, sizeof scratch->sums);
    for (int i = 0; i < LANES; i++) scratch->sums.nearest[i] = INFINITY;
    const bool done =
        half ? trace_half(&g, half, scratch, paths) : trace_on(&g, &g, &scratch->sums, paths);
    if (!done) return;
    store_lobes(c, block, &scratch->lobes, samples);
    store_axes(c, block, &scratch->lobes, samples);
    store(&g, &scratch->sums, samples);
    if (samples->layout.planes >> PLANE_GLOSSY_SPAN & 1) store_span(&g, &scratch->sums, samples);
}
