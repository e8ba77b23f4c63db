#include "worker/trace/path/path.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "worker/trace/path/centre_gbuffer.h"
#include "worker/trace/path/chains.h"
#include "worker/trace/path/glossy_lobes.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_leave.h"
#include "worker/trace/path/path_photograph.h"
#include "worker/trace/path/path_record.h"

void path_scratch_init(struct path_scratch *s)
{
    memset(s, 0, sizeof *s);
    path_pool_init(&s->pools[0]);
    path_pool_init(&s->pools[1]);
    path_pool_init(&s->real[0]);
    path_pool_init(&s->real[1]);
    for (int k = 0; k < 2; k++) {
        queries_init_rays(&s->light[k].packet.rays);
        queries_init_rays(&s->light[k].candidate.rays);
    }
    queries_init_rays(&s->occlusion);
}

/* Volumes dim what passes through them; a path that meets a surface from behind was inside. */
static void attenuate(struct path_packet *p, const struct path_vertex *v)
{
    const struct surface *s = &v->surface;
    struct lanes3 *t = &p->throughput;
    for (uint32_t i = 0; i < p->count; i++) {
        float left[3];
        if (!(s->hit.on[i] & s->behind.on[i]) || !s->mesh[i]->material->volume) continue;
        material_attenuation(s->mesh[i]->material, s->distance[i], left);
        t->x[i] *= left[0];
        t->y[i] *= left[1];
        t->z[i] *= left[2];
    }
}

/* A path has one colour at all dispersed volumes. The first that it passes leaves it that alone. */
static void choose_colors(const struct path_packet *p, struct path_vertex *v)
{
    for (uint32_t i = 0; i < p->count; i++) {
        float u, unused;
        if (!path_is_dispersed(v, (int)i)) continue;
        path_pair(p->key[i], p->sample[i], PATH_COLOR, &u, &unused);
        const int color = (int)(3.0f * u);
        bsdf_choose_color(&v->bsdf[i], color < 2 ? color : 2, p->colored[i] ? 1.0f : 3.0f);
    }
}

/* Finds what each path's surface does to light; paths that it takes nowhere end. */
static void prepare(const struct path_context *c, const struct path_packet *p,
                    struct path_vertex *v)
{
    const struct surface *s = &v->surface;
    struct lanes_mask lights;
    for (int i = 0; i < LANES; i++) v->active.on[i] = s->hit.on[i] & -(i < (int)p->count);
    path_resolve(c, &p->rays, v);
    if (v->any_general) choose_colors(p, v);
    for (int i = 0; i < LANES; i++)
        lights.on[i] = -(s->albedo.x[i] + s->albedo.y[i] + s->albedo.z[i] > 0.0f);
    for (int i = 0; v->any_general && i < LANES; i++)
        if (!v->lambert.on[i]) lights.on[i] = v->bsdf[i].model != BSDF_BLACK ? -1 : 0;
    const uint32_t met = lanes_count(&v->active);
    for (int i = 0; i < LANES; i++) v->active.on[i] &= lights.on[i];
    for (int i = 0; i < LANES; i++) v->lambert.on[i] &= lights.on[i];
    v->any_lambert = lanes_count(&v->lambert) > 0;
    c->counters->value[COUNTER_SKIPPED_BLACK_ALBEDO] += met - lanes_count(&v->active);
}

/* Cosine-distributed rays that look for anything nearer than the plan's distance. */
static void trace_occlusion(const struct path_context *c, const struct path_packet *p,
                            const struct path_vertex *v, struct RTCRayHit16 *rays,
                            struct path_radiance *h)
{
    _Alignas(LANES_ALIGN) float u[LANES], w[LANES], pdf[LANES];
    struct lanes_mask valid = v->surface.hit;
    struct lanes3 direction;
    struct RTCRay16 *r = &rays->ray;
    c->kernels->path_pairs(p, PATH_OCCLUSION, u, w);
    c->kernels->lambert_scatter(&v->surface, u, w, &valid, &direction, pdf);
    for (int i = 0; i < LANES; i++) {
        const struct vector start =
            surface_start(&v->surface, i, direction.x[i], direction.y[i], direction.z[i]);
        r->org_x[i] = start.x;
        r->org_y[i] = start.y;
        r->org_z[i] = start.z;
        r->dir_x[i] = direction.x[i];
        r->dir_y[i] = direction.y[i];
        r->dir_z[i] = direction.z[i];
        r->tnear[i] = 0.0f;
        r->tfar[i] = c->plan->occlusion_distance;
        r->time[i] = p->rays.ray.time[i];
    }
    if (c->blended) c->kernels->ray_keys(p, 0, PATH_RAY_OCCLUSION, r);
    queries_sanitise(c->queries, &valid, r);
    c->counters->value[COUNTER_RAYS_OCCLUSION] += lanes_count(&valid);
    queries_occluded(c->queries, QUERY_BOUNCE_SHADOW, &valid, rays);
    for (uint32_t i = 0; i < p->count; i++) {
        bool blocked = v->surface.hit.on[i] && (!valid.on[i] || r->tfar[i] < 0.0f);
        h->occlusion[p->slot[i]] = blocked ? 0.0f : 1.0f;
    }
}

void path_note_reach(const struct path_packet *p, const struct lanes_mask *valid,
                     struct path_radiance *h)
{
    const struct RTCRayHit16 *r = &p->rays;
    for (uint32_t i = 0; i < p->count; i++) {
        bool hit = r->hit.geomID[i] != RTC_INVALID_GEOMETRY_ID && r->ray.tfar[i] < INFINITY;
        float reach = r->ray.tfar[i] > FLT_MIN ? r->ray.tfar[i] : FLT_MIN; /* a hit, at 0 too */
        if (valid->on[i]) h->distance[p->slot[i]] = hit ? reach : INFINITY;
    }
}

/* Reflections have been scatterings, too. */
static void end_mirrored(const struct path_context *c, const struct path_packet *p,
                         struct path_vertex *v, const struct path_radiance *h)
{
    struct lanes_mask ended = {{0}};
    for (uint32_t i = 0; i < p->count; i++)
        ended.on[i] = v->depth + h->mirrored[p->slot[i]] > c->plan->bounces ? -1 : 0;
    if (lanes_count(&ended) > 0) path_end_lanes(&ended, v);
}

/* Where light fields are sure to light what paths of the lens see, these need not: they end, or
 * leave the indirect light of diffuse lobes out. */
static void leave_to_fields(const struct path_context *c, const struct path_packet *p,
                            struct path_vertex *v, struct path_radiance *h)
{
    struct lanes_mask lit;
    struct glossy_lobes lobes = {.on = {{0}}};
    if (c->skip & SKIP_GLOSSY_OF_LENS) glossy_lobes_find(v, &lobes);
    centre_gbuffer_match(c->centres, p, v, &lobes, &lit);
    for (uint32_t i = 0; i < p->count; i++) h->own[p->slot[i]] = lit.on[i] ? 0.0f : 1.0f;
    for (uint32_t i = 0; i < p->count; i++) {
        if (!lobes.on.on[i]) continue;
        h->lobe.r[p->slot[i]] = lobes.reflectance.x[i];
        h->lobe.g[p->slot[i]] = lobes.reflectance.y[i];
        h->lobe.b[p->slot[i]] = lobes.reflectance.z[i];
        if (v->mirrors.any) path_dim(&h->lobe, p->slot[i], &v->mirrors.tint, i);
    }
    if (c->skip & SKIP_DIFFUSE_INDIRECT) return;
    c->counters->value[COUNTER_SKIPPED_LIGHT_FIELD] += lanes_count(&lit);
    path_end_lanes(&lit, v);
    if (c->record && lit.on[0]) path_record_leave(c, p, v);
}

/* Rectangles whose centre is farther than so many of their half diagonals light evenly enough. */
#define FAR 2.0f

/* Finds which paths of the light field need not look for lights by a last ray: at Lambert
 * surfaces far from all lights, where a light sample's own variance is bounded, the ray costs
 * half as much again and spares 2 % of the variance (Cornell box). Surfaces alone decide, so
 * that both ways of finding a light agree on who counts it. */
static void find_last(const struct path_context *c, struct path_vertex *v)
{
    const struct lanes3 *at = &v->surface.position;
    memset(&v->last, 0, sizeof v->last);
    if (!(c->field && c->lights_only) || v->depth < c->plan->bounces) return;
    v->last = v->lambert;
    for (uint32_t k = 0; k < c->lights->count; k++) {
        const struct plan_light *light = c->lights->lights[k].plan;
        const float *p = light->position, *hu = light->half_u, *hv = light->half_v;
        if (light->type != LIGHT_RECTANGLE) continue;
        const float near = FAR * FAR *
                           (hu[0] * hu[0] + hu[1] * hu[1] + hu[2] * hu[2] + hv[0] * hv[0] +
                            hv[1] * hv[1] + hv[2] * hv[2]);
        for (int i = 0; i < LANES; i++) {
            float x = at->x[i] - p[0], y = at->y[i] - p[1], z = at->z[i] - p[2];
            v->last.on[i] &= -(x * x + y * y + z * z > near);
        }
    }
}

static void end_last(const struct path_context *c, struct path_vertex *v)
{
    uint32_t ended = lanes_count(&v->last);
    if (ended == 0) return;
    c->counters->value[COUNTER_SKIPPED_LAST_SEGMENT] += ended;
    path_end_lanes(&v->last, v);
}

/* Traces the packet's rays and adds what they meet; v has the surfaces that light up. */
static void follow(const struct path_context *c, struct path_packet *p, struct path_vertex *v,
                   struct path_radiance *h)
{
    struct lanes_mask valid;
    const bool camera = v->depth == 0;
    path_packet_lanes(p, &valid);
    if (c->blended) c->kernels->ray_keys(p, v->depth, PATH_RAY_NEXT, &p->rays.ray);
    queries_sanitise(c->queries, &valid, &p->rays.ray);
    c->counters->value[camera ? COUNTER_RAYS_PRIMARY : COUNTER_RAYS_INDIRECT] +=
        lanes_count(&valid);
    queries_closest(c->queries, camera ? QUERY_CAMERA : QUERY_BOUNCE, &valid, &p->rays);
    hit_resolve(c->queries, &valid, &p->rays, &v->surface);
    v->mirrors.any = false;
    if (camera && c->mirrors) mirrors_follow(c, p, &p->rays, v);
    if (c->field && v->depth == PATH_FIELD_DEPTH) path_note_reach(p, &valid, h);
    attenuate(p, v);
    if (c->record) path_record_arrive(c, p, v);
    path_emission_add(c, p, v, h);
    prepare(c, p, v);
    if (c->record) path_record_surface(c, v);
}

/* real: where paths begin that bring what is without objects; NULL: these are such paths. */
static void trace_packet(const struct path_context *c, uint32_t depth, struct path_packet *p,
                         struct path_scratch *s, struct path_pool *next, struct path_pool *real)
{
    struct path_vertex *v = &s->vertex;
    v->depth = depth;
    v->far = NULL;
    v->is_far = false;
    follow(c, p, v, &s->radiance);
    if (depth == 0) path_note(c, p, v, &s->radiance);
    if (c->seen_only) return;
    if (depth > 0 && c->chains) chains_note(c, p, v, &s->radiance);
    if (depth == 0 && c->centres) leave_to_fields(c, p, v, &s->radiance);
    if (depth == 0 && !c->lens && (c->plan->planes >> PLANE_PATH_VISIBILITY & 1u))
        trace_occlusion(c, p, v, &s->occlusion, &s->radiance);
    if (depth == 0 && (c->skip & SKIP_DIFFUSE)) path_leave_surface(c, p, v, &s->radiance);
    if (depth > c->plan->bounces || !(v->any_lambert || v->any_general)) return;
    if (c->photograph && real && depth > 0) path_photograph_meet(c, p, v, s, real);
    if (c->mirrors && depth > 0) end_mirrored(c, p, v, &s->radiance);
    if (depth == 1 && (c->skip & SKIP_DIFFUSE_INDIRECT)) path_leave_diffuse(c, p, v, &s->radiance);
    if (!(v->any_lambert || v->any_general)) return;
    find_last(c, v);
    if (v->any_general) layers_see(c->kernels, v, &v->layers);
    if (depth == 0 && (c->skip & SKIP_DIFFUSE)) path_thin_lobes(c, p, v);
    if (depth == 0 && (c->skip & SKIP_LISTED)) path_leave_listed(p, v, &s->radiance);
    if (!light_table_is_empty(c->lights)) path_nee_add(c, p, v, s->light, &s->radiance);
    if (!light_table_is_empty(c->lights) && path_far_find(v, &s->far)) {
        path_nee_add(c, p, &s->far, s->light, &s->radiance);
        v->far = &s->far;
    }
    if (depth == c->plan->bounces && !c->has_emission) v->last = v->active;
    end_last(c, v);
    if (v->any_lambert || v->any_general) path_scatter(c, p, v, &s->radiance, next);
}

static void trace_pool(const struct path_context *c, uint32_t depth, struct path_pool *now,
                       struct path_scratch *s, struct path_pool *next, struct path_pool *real)
{
    next->count = 0;
    for (uint32_t k = 0; k < path_pool_packets(now); k++)
        trace_packet(c, depth, &now->packets[k], s, next, real);
    now->count = 0;
}

/* Traces the paths in pools[0] to their ends. */
static void trace_on(const struct path_context *c, uint32_t depth, struct path_scratch *s)
{
    const struct query_view *view = c->queries->view;
    unsigned at = 0;
    for (; s->pools[at].count + s->real[at].count > 0; depth++, at ^= 1) {
        trace_pool(c, depth, &s->pools[at], s, &s->pools[at ^ 1], &s->real[at]);
        if (s->real[at].count == 0) continue;
        c->queries->view = query_view_of(PLAN_VIEW_WITHOUT);
        trace_pool(c, depth, &s->real[at], s, &s->real[at ^ 1], NULL);
        c->queries->view = view;
    }
}

void path_trace(const struct path_context *c, const struct block *b, uint32_t first, uint32_t count,
                struct path_scratch *s)
{
    path_camera(c, b, first, count, &s->pools[0]);
    path_trace_camera(c, s);
}

void path_trace_camera(const struct path_context *c, struct path_scratch *s)
{
    const size_t shown = c->photograph ? sizeof s->radiance.shown : 0;
    memset(&s->radiance, 0, offsetof(struct path_radiance, shown) + shown);
    trace_on(c, 0, s);
}

void path_trace_field(const struct path_context *c, struct path_scratch *s)
{
    trace_on(c, PATH_FIELD_DEPTH, s);
}
