/* Chooses where paths go on. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/shade/glossy.h"
#include "worker/trace/path/chains.h"
#include "worker/trace/path/path_guide.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_record.h"

/* After this scattering paths are ended by chance in proportion to what they still carry. Variance
 * times time on the Cornell box with 63 bounces, by this depth: 0: 33, 1: 31, 2: 38, 3: 40,
 * 5: 48. */
#define ROULETTE_DEPTH 1

/* Paths in chains go on, unless they carry next to nothing: an end would tell filters of the glass
 * itself. */
#define SURELY    (-1.0f)
#define CARRY_MIN 1e-3f

static bool carries(const struct path_packet *p, uint32_t i)
{
    return fmaxf(p->throughput.x[i], fmaxf(p->throughput.y[i], p->throughput.z[i])) > CARRY_MIN;
}

static void scatter_lambert(const struct path_context *c, const struct path_vertex *v,
                            const float u[LANES], const float w[LANES], struct path_scattering *s)
{
    s->on = v->active;
    c->kernels->lambert_scatter(&v->surface, u, w, &s->on, &s->direction, s->pdf);
    s->weight = v->surface.albedo;
    for (int i = 0; i < LANES; i++) s->diffuse[i] = 1.0f;
    memset(&s->specular, 0, sizeof s->specular);
    memset(&s->through, 0, sizeof s->through);
}

static bool leaves(const struct surface *s, int i, const float d[3], bool through)
{
    float facet = d[0] * s->facet.x[i] + d[1] * s->facet.y[i] + d[2] * s->facet.z[i];
    return through ? facet < 0.0f : facet > 0.0f;
}

/* Keeps the shares of weights that are diffuse lobes', over their albedo. They turn all that comes
 * along the new directions into demodulated light. */
static void keep_shares(const struct path_packet *p, const struct path_vertex *v,
                        const struct path_scattering *s, struct path_radiance *h)
{
    const struct lanes3 *w = &s->weight;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!(v->active.on[i] & s->on.on[i]) || v->lambert.on[i]) continue;
        h->share.r[slot] = w->x[i] > 0.0f ? s->diffuse[i] / w->x[i] : 0.0f;
        h->share.g[slot] = w->y[i] > 0.0f ? s->diffuse[i] / w->y[i] : 0.0f;
        h->share.b[slot] = w->z[i] > 0.0f ? s->diffuse[i] / w->z[i] : 0.0f;
    }
}

/* Keeps the parts of weights that light fields do not bring. They bring the diffuse lobe's part and
 * the glossy lobe's, beside which such a surface has no other. Lambert surfaces keep nothing. */
static void keep_rest(const struct path_context *c, const struct path_packet *p,
                      const struct path_vertex *v, const struct path_scattering *s,
                      struct path_radiance *h)
{
    const struct lanes3 *w = &s->weight, *rest = &s->specular;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!(v->active.on[i] & s->on.on[i]) || v->lambert.on[i]) continue;
        if ((c->skip & SKIP_GLOSSY_INDIRECT) && glossy_has(&v->bsdf[i]))
            continue; /* nothing, as slots begin */
        if (h->lobe.r[slot] + h->lobe.g[slot] + h->lobe.b[slot] > 0.0f) continue;
        h->kept.r[slot] = w->x[i] > 0.0f ? rest->x[i] / w->x[i] : 0.0f;
        h->kept.g[slot] = w->y[i] > 0.0f ? rest->y[i] / w->y[i] : 0.0f;
        h->kept.b[slot] = w->z[i] > 0.0f ? rest->z[i] / w->z[i] : 0.0f;
    }
}

static void scatter_general(const struct path_vertex *v, int i, float choice, const float u[2],
                            struct path_scattering *out)
{
    const struct surface *s = &v->surface;
    const struct bsdf *b = &v->bsdf[i];
    const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]};
    struct bsdf_sample sample;
    out->on.on[i] = 0;
    if (!bsdf_sample(b, wo, choice, u, &sample)) return;
    float d[3];
    path_from_frame(v, i, sample.wi, d);
    if (!leaves(s, i, d, sample.transmitted)) return;
    float weight[3];
    for (int k = 0; k < 3; k++) weight[k] = b->albedo[k] * sample.diffuse + sample.specular[k];
    out->on.on[i] = -1;
    out->direction.x[i] = d[0];
    out->direction.y[i] = d[1];
    out->direction.z[i] = d[2];
    out->weight.x[i] = weight[0];
    out->weight.y[i] = weight[1];
    out->weight.z[i] = weight[2];
    out->through.on[i] = sample.transmitted ? -1 : 0;
    /* Light samples look at the far side of translucent surfaces only. */
    const bool sampled = !sample.transmitted || (v->far && v->far->active.on[i]);
    out->pdf[i] = sample.dirac || !sampled ? 0.0f : sample.pdf;
    out->diffuse[i] = sample.diffuse;
    out->specular.x[i] = sample.specular[0];
    out->specular.y[i] = sample.specular[1];
    out->specular.z[i] = sample.specular[2];
}

/* Keeps the shares of pure Lambert surfaces, after which all that comes is diffuse. */
static void keep_lambert_shares(const struct path_packet *p, const struct path_vertex *v,
                                struct path_radiance *h)
{
    const struct lanes3 *a = &v->surface.albedo;
    for (uint32_t i = 0; i < p->count; i++) {
        if (!v->lambert.on[i]) continue;
        uint32_t slot = p->slot[i];
        h->share.r[slot] = a->x[i] > 0.0f ? 1.0f / a->x[i] : 0.0f;
        h->share.g[slot] = a->y[i] > 0.0f ? 1.0f / a->y[i] : 0.0f;
        h->share.b[slot] = a->z[i] > 0.0f ? 1.0f / a->z[i] : 0.0f;
    }
}

static float over(float share, float tint)
{
    return tint > 0.0f ? share / tint : 0.0f;
}

/* Takes the tint of mirrors out of shares, as albedo is. */
static void untint_shares(const struct path_packet *p, const struct path_vertex *v,
                          struct path_radiance *h)
{
    const struct lanes3 *tint = &v->mirrors.tint;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!v->active.on[i] || v->mirrors.count[i] == 0) continue;
        h->share.r[slot] = over(h->share.r[slot], tint->x[i]);
        h->share.g[slot] = over(h->share.g[slot], tint->y[i]);
        h->share.b[slot] = over(h->share.b[slot], tint->z[i]);
    }
}

static void start_segment(const struct path_packet *p, const struct path_vertex *v,
                          const struct path_scattering *s, uint32_t i, struct path_packet *next,
                          uint32_t lane)
{
    const struct surface *from = &v->surface;
    struct RTCRay16 *r = &next->rays.ray;
    bool through = s->through.on[i];
    const struct path_vertex *sampled = through && v->far ? v->far : v;
    const struct vector start =
        surface_start(from, (int)i, s->direction.x[i], s->direction.y[i], s->direction.z[i]);
    /* The other side's origin lies as far behind the position as this side's before it. */
    r->org_x[lane] = through ? 2.0f * from->position.x[i] - from->origin.x[i] : start.x;
    r->org_y[lane] = through ? 2.0f * from->position.y[i] - from->origin.y[i] : start.y;
    r->org_z[lane] = through ? 2.0f * from->position.z[i] - from->origin.z[i] : start.z;
    r->dir_x[lane] = s->direction.x[i];
    r->dir_y[lane] = s->direction.y[i];
    r->dir_z[lane] = s->direction.z[i];
    r->tnear[lane] = 0.0f;
    r->tfar[lane] = INFINITY;
    r->time[lane] = p->rays.ray.time[i];
    next->key[lane] = p->key[i];
    next->sample[lane] = p->sample[i];
    next->slot[lane] = p->slot[i];
    next->colored[lane] = p->colored[i] | (through && path_is_dispersed(v, (int)i));
    next->pdf[lane] = s->pdf[i];
    next->promise[lane] = s->promise[i];
    next->sky_table[lane] = sampled->sky_table[i];
    next->sky_share[lane] = sampled->sky_share[i];
    next->lights[lane] = sampled->weights.total[i];
    from = &sampled->surface;
    next->from.x[lane] = from->origin.x[i];
    next->from.y[lane] = from->origin.y[i];
    next->from.z[lane] = from->origin.z[i];
    next->normal.x[lane] = from->normal.x[i];
    next->normal.y[lane] = from->normal.y[i];
    next->normal.z[lane] = from->normal.z[i];
}

/* Returns whether all that the path could bring is the light field's, since nothing can send it
 * direct light. */
static bool is_left_out(const struct path_context *c, const struct path_vertex *v, uint32_t slot,
                        const struct path_radiance *h)
{
    if (!(c->skip & SKIP_DIFFUSE_INDIRECT) || v->depth > 0 || c->has_other_emission ||
        h->own[slot] > 0.0f)
        return false;
    return !(h->kept.r[slot] + h->kept.g[slot] + h->kept.b[slot] > 0.0f);
}

/* Ends the lanes of *on that light fields stand for. */
static void leave_out(const struct path_context *c, const struct path_packet *p,
                      const struct path_vertex *v, const struct path_radiance *h,
                      struct lanes_mask *on)
{
    for (uint32_t i = 0; i < p->count; i++) {
        if (!on->on[i] || !is_left_out(c, v, p->slot[i], h)) continue;
        on->on[i] = 0;
        c->counters->value[COUNTER_SKIPPED_LIGHT_FIELD]++;
    }
}

/* Finds the lanes whose segments are traced, and their throughputs. */
static void find_segments(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, const struct path_scattering *s,
                          const struct path_radiance *h, struct lanes_mask *on,
                          struct lanes3 *throughput)
{
    const struct path_kernels *kernels = c->kernels;
    const uint32_t dimension = PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_ROULETTE;
    const bool roulette = v->depth >= ROULETTE_DEPTH;
    _Alignas(LANES_ALIGN) float chance[LANES], unused[LANES];
    struct lanes_mask stays;
    uint64_t *counters = c->counters->value;
    for (int i = 0; i < LANES; i++) on->on[i] = v->active.on[i] & s->on.on[i];
    counters[COUNTER_SKIPPED_BOUNCE_BELOW_HORIZON] += lanes_count(&v->active) - lanes_count(on);
    if ((c->skip & SKIP_DIFFUSE_INDIRECT) && v->depth == 0) leave_out(c, p, v, h, on);
    if (roulette) kernels->path_pairs(p, dimension, chance, unused);
    for (uint32_t i = 0; roulette && i < p->count; i++)
        if (chains_go_on(p, v, h, i) && carries(p, i)) chance[i] = SURELY;
    kernels->weigh_segments(p, s, roulette ? chance : NULL, throughput, &stays);
    const uint32_t chosen = lanes_count(on);
    for (int i = 0; i < LANES; i++) on->on[i] &= stays.on[i];
    counters[COUNTER_SKIPPED_ROULETTE] += chosen - lanes_count(on);
}

/* Notes what the path's next segment is part of. */
static void start_part(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, uint32_t i, struct path_packet *next,
                       uint32_t lane)
{
    const uint8_t part = p->part[i];
    next->part[lane] = part == PATH_PART_ARRIVING ? PATH_PART_WITHOUT : part;
    next->from_object[lane] = 0;
    if (!c->photograph) return;
    const struct scene_instance *instances = c->queries->scene->blob->instances;
    next->from_object[lane] =
        instance_class(&instances[v->surface.id[i] - 1]) == INSTANCE_IS_VIRTUAL;
}

static void append(const struct path_context *c, const struct path_packet *p,
                   const struct path_vertex *v, const struct path_scattering *s,
                   const struct path_radiance *h, struct path_pool *pool)
{
    struct lanes_mask on;
    struct lanes3 throughput;
    uint32_t lanes[LANES], count = 0;
    find_segments(c, p, v, s, h, &on, &throughput);
    for (uint32_t i = 0; i < LANES; i++) { /* which go on is chance: no branch */
        lanes[count] = i;
        count += on.on[i] != 0;
    }
    for (uint32_t k = 0; k < count; k++) {
        uint32_t lane, i = lanes[k];
        struct path_packet *next = path_pool_add(pool, &lane);
        next->throughput.x[lane] = throughput.x[i];
        next->throughput.y[lane] = throughput.y[i];
        next->throughput.z[lane] = throughput.z[i];
        start_segment(p, v, s, i, next, lane);
        start_part(c, p, v, i, next, lane);
    }
}

/* Records the only path's next segment. */
PATH_RECORD_COLD static void record(const struct path_context *c, const struct path_packet *p,
                                    const struct path_vertex *v, const struct path_scattering *s,
                                    const struct path_radiance *h, const struct path_pool *next)
{
    struct path_record_scatter to = {
        .on = s->on.on[0],
        .transmitted = s->through.on[0],
        .direction = {s->direction.x[0], s->direction.y[0], s->direction.z[0]},
        .weight = {s->weight.x[0], s->weight.y[0], s->weight.z[0]},
        .pdf = s->pdf[0],
        .left_out = is_left_out(c, v, p->slot[0], h),
        .goes_on = next->count > 0};
    const struct lanes3 *t = &p->throughput;
    const float most = s->promise[0] * fmaxf(t->x[0] * to.weight[0],
                                             fmaxf(t->y[0] * to.weight[1], t->z[0] * to.weight[2]));
    const float rest[3] = {s->specular.x[0], s->specular.y[0], s->specular.z[0]};
    for (int k = 0; k < 3; k++) to.specular[k] = rest[k];
    for (int k = 0; k < 3; k++) to.diffuse[k] = to.weight[k] - rest[k];
    to.roulette = to.on && !to.left_out && v->depth >= ROULETTE_DEPTH &&
                  !(chains_go_on(p, v, h, 0) && carries(p, 0));
    to.survival = most < PATH_ROULETTE_MAX ? most : PATH_ROULETTE_MAX;
    path_record_scatter(c, p, v, &to);
}

/* Scatters lanes that have a bsdf. */
static void scatter_generals(const struct path_context *c, const struct path_packet *p,
                             const struct path_vertex *v, const float u[LANES],
                             const float w[LANES], struct path_scattering *s)
{
    const struct path_kernels *kernels = c->kernels;
    const uint32_t dimension = PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_CHOICE;
    _Alignas(LANES_ALIGN) float lobe[LANES], light[LANES];
    kernels->path_pairs(p, dimension, lobe, light);
    if (v->layers.any) kernels->layers_scatter(v, lobe, u, w, s);
    for (int i = 0; v->layers.others && i < LANES; i++) {
        const float at[2] = {u[i], w[i]};
        if (v->active.on[i] && !v->lambert.on[i] && !v->layers.on.on[i])
            scatter_general(v, i, lobe[i], at, s);
    }
}

/* Returns whether a surface sends paths on that were sent to what lies beyond it. */
static bool sends_on(const struct bsdf *b)
{
    return b->transmission > 0.0f || (b->metallic > 0.5f && bsdf_sharpest_alpha(b) < 0.05f);
}

/* Keeps what paths promise that are still on their way through glass or from mirrors. */
static void keep_promises(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct path_scattering *s)
{
    for (int i = 0; i < LANES; i++) s->promise[i] = 1.0f;
    for (int i = 0; c->guided && v->any_general && i < LANES; i++)
        if (v->active.on[i] && !v->lambert.on[i] && sends_on(&v->bsdf[i]))
            s->promise[i] = p->promise[i];
}

static void choose_directions(const struct path_context *c, const struct path_packet *p,
                              const struct path_vertex *v, struct path_scattering *s)
{
    const uint32_t dimension = PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_DIRECTION;
    _Alignas(LANES_ALIGN) float u[LANES], w[LANES];
    struct path_guide guide;
    if (!v->any_lambert) memset(s, 0, sizeof *s);
    keep_promises(c, p, v, s);
    c->kernels->path_pairs(p, dimension, u, w);
    const bool guided = c->guided && path_guide_find(c, v, &guide);
    if (guided) path_guide_aim(c, p, v, &guide, u, w);
    if (v->any_lambert) scatter_lambert(c, v, u, w, s);
    if (v->any_general) scatter_generals(c, p, v, u, w, s);
    if (guided) path_guide_turn(c, v, &guide, s);
}

void path_scatter(const struct path_context *c, const struct path_packet *p,
                  const struct path_vertex *v, struct path_radiance *h, struct path_pool *next)
{
    const bool first = v->depth == 0;
    struct path_scattering s;
    choose_directions(c, p, v, &s);
    if (v->any_lambert && c->demodulate && first) keep_lambert_shares(p, v, h);
    if (v->any_general && c->demodulate && first) keep_shares(p, v, &s, h);
    const bool leaves = (c->skip & (SKIP_DIFFUSE_INDIRECT | SKIP_LISTED)) != 0;
    if (v->any_general && leaves && first) keep_rest(c, p, v, &s, h);
    chains_scatter(c, p, v, &s, h);
    if (v->mirrors.any && c->demodulate) untint_shares(p, v, h);
    append(c, p, v, &s, h, next);
    if (c->record) record(c, p, v, &s, h, next);
}
