/* Samples one point of one light for every vertex, and traces its shadow ray. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/emitters.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_nee.h"
#include "worker/trace/path/path_record.h"

/* Shadow rays end just short of a mesh emitter's point, beside the offset of the point itself. */
#define EMITTER_END 0.9999f

static float probability_of(const struct light_table *t, uint32_t chosen)
{
    if (chosen == LIGHT_CHOICE_EMITTERS) return t->emitters_probability;
    if (chosen == LIGHT_CHOICE_ENVIRONMENT) return t->environment_probability;
    return t->lights[chosen].probability;
}

static bool is_one_light(const struct light_table *t)
{
    return t->count == 1 && !(t->emitters_probability > 0.0f) &&
           !(t->environment_probability > 0.0f);
}

static void choose(const struct path_context *c, const struct path_packet *p,
                   const struct path_vertex *v, struct light_selection *out)
{
    const struct path_kernels *kernels = c->kernels;
    const uint32_t base = PATH_VERTEX + v->depth * PATH_PER_VERTEX;
    _Alignas(LANES_ALIGN) float lobe[LANES], which[LANES], unused[LANES];
    out->plan_lights = 0;
    out->others = out->emitters = false;
    kernels->path_pairs(p, base + PATH_LIGHT, out->u, out->v);
    kernels->path_pairs(p, base + PATH_CHOICE, lobe, which);
    kernels->path_pairs(p, base + PATH_ROULETTE, unused, out->pick);
    for (int i = 0; i < LANES; i++) {
        out->chosen[i] = UINT32_MAX;
        out->soft[i] = 0.0f;
        out->probability[i] = 1.0f;
        if (!v->active.on[i]) continue;
        uint32_t chosen = light_table_choose(c->lights, which[i]);
        out->chosen[i] = chosen;
        out->probability[i] = probability_of(c->lights, chosen);
        out->which[i] = which[i];
        out->emitters |= chosen == LIGHT_CHOICE_EMITTERS;
        if (chosen < LIMIT_LIGHTS)
            out->plan_lights |= UINT64_C(1) << chosen;
        else
            out->others = true;
    }
}

/* Samples the lanes that chose lights of the plan. One light for all needs no copying. */
static void sample_plan_lights(const struct path_context *c, const struct path_vertex *v,
                               const struct light_selection *selection, struct nee_sample *out)
{
    const struct light_kernels *kernels = c->light_kernels;
    const struct light *lights = c->lights->lights;
    if (!selection->others && (selection->plan_lights & (selection->plan_lights - 1)) == 0) {
        kernels->sample_light(&lights[__builtin_ctzll(selection->plan_lights)], selection->u,
                              selection->v, &v->surface, &v->active, &out->packet);
        return;
    }
    for (uint64_t rest = selection->plan_lights; rest; rest &= rest - 1) {
        uint32_t index = (uint32_t)__builtin_ctzll(rest);
        kernels->sample_light(&lights[index], selection->u, selection->v, &v->surface, &v->active,
                              &out->candidate);
        for (int i = 0; i < LANES; i++)
            if (selection->chosen[i] == index) light_take_lane(&out->candidate, i, &out->packet);
    }
}

/* The group that x in [0, 1) chooses in proportion to how much it may light lane i, and the
 * probability of that. 0: none lights it. */
static float choose_group(const struct group_light *light, uint32_t count, int i, float x,
                          uint32_t *group)
{
    const float target = x * light->total[i];
    float upto = 0.0f, of = 0.0f;
    *group = 0;
    for (uint32_t g = 0; g < count; g++) {
        const float one = light->group[g][i];
        if (!(one > 0.0f)) continue;
        upto += one;
        of = one;
        *group = g;
        if (target < upto) break;
    }
    return of > 0.0f ? of / light->total[i] : 0.0f;
}

/* Lights of the plan come before the emitters, the environment after them. */
static float within_emitters(const struct light_table *t, float which)
{
    const float before = t->count > 0 ? t->lights[t->count - 1].probability_upto : 0.0f;
    const float x = (which - before) / t->emitters_probability;
    return x > 0.0f ? (x < 0x1.fffffep-1f ? x : 0x1.fffffep-1f) : 0.0f;
}

static void sample_emitter(const struct path_context *c, const struct path_vertex *v,
                           const struct light_selection *selection, int i, struct nee_sample *out)
{
    const struct surface *s = &v->surface;
    struct light_packet *p = &out->packet;
    struct RTCRay16 *r = &p->rays.ray;
    const struct emitters *emitters = c->queries->scene->emitters;
    struct emitter_point e;
    float u[2] = {selection->u[i], selection->v[i]};
    uint32_t group;
    const float chance = choose_group(&out->groups, emitters_groups(emitters)->count, i,
                                      within_emitters(c->lights, selection->which[i]), &group);
    p->skip[i] = LIGHT_FACING_AWAY;
    if (!(chance > 0.0f)) return;
    emitters_sample(emitters, group, selection->pick[i], u, &e);
    float way[3] = {e.position[0] - s->position.x[i], e.position[1] - s->position.y[i],
                    e.position[2] - s->position.z[i]};
    float squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    float front = -(way[0] * e.normal[0] + way[1] * e.normal[1] + way[2] * e.normal[2]);
    float side = front < 0.0f ? -1.0f : 1.0f;
    if (!path_nee_aim(v, i, way, sqrtf(squared), p)) return;
    if (front == 0.0f || (front < 0.0f && !e.double_sided)) {
        p->skip[i] = LIGHT_FACING_AWAY;
        return;
    }
    /* front, and so squared, are positive here */
    p->density[i] = chance * e.pdf_area * squared * sqrtf(squared) / fabsf(front);
    p->irradiance[i] /= p->density[i];
    float clear = side * fminf(e.offset, 0.5f * fabsf(front));
    r->dir_x[i] = e.position[0] + clear * e.normal[0] - s->origin.x[i];
    r->dir_y[i] = e.position[1] + clear * e.normal[1] - s->origin.y[i];
    r->dir_z[i] = e.position[2] + clear * e.normal[2] - s->origin.z[i];
    r->tfar[i] = EMITTER_END;
    out->color.x[i] = e.radiance[0];
    out->color.y[i] = e.radiance[1];
    out->color.z[i] = e.radiance[2];
}

static void sample_others(const struct path_context *c, const struct path_vertex *v,
                          struct light_selection *selection, struct nee_sample *out)
{
    struct light_packet *p = &out->packet;
    path_nee_sample_sky(c, v, selection, out);
    if (selection->emitters)
        c->kernels->group_light(emitters_groups(c->queries->scene->emitters), &v->surface.origin,
                                &v->surface.normal, &out->groups);
    for (int i = 0; i < LANES; i++) {
        if (selection->chosen[i] == UINT32_MAX || selection->chosen[i] < LIMIT_LIGHTS) continue;
        if (selection->chosen[i] == LIGHT_CHOICE_EMITTERS) sample_emitter(c, v, selection, i, out);
        bool fit = p->skip[i] == LIGHT_TRACED && p->irradiance[i] < INFINITY;
        if (p->skip[i] == LIGHT_TRACED && !fit) p->skip[i] = LIGHT_NOT_FINITE;
        p->traced.on[i] = fit ? -1 : 0;
    }
}

/* Divides the colors by the probability of their selection. */
static void finish_colors(const struct path_context *c, const struct light_selection *selection,
                          struct nee_sample *out)
{
    for (int i = 0; i < LANES; i++) {
        const float own[3] = {out->color.x[i], out->color.y[i], out->color.z[i]};
        const float *color = own, share = 1.0f / selection->probability[i];
        if (selection->chosen[i] < LIMIT_LIGHTS)
            color = c->lights->lights[selection->chosen[i]].plan->color;
        out->color.x[i] = share * color[0];
        out->color.y[i] = share * color[1];
        out->color.z[i] = share * color[2];
    }
}

/* Sets the rays' origins. */
static void finish_rays(const struct path_vertex *v, struct RTCRay16 *r)
{
    memcpy(r->org_x, v->surface.origin.x, sizeof r->org_x);
    memcpy(r->org_y, v->surface.origin.y, sizeof r->org_y);
    memcpy(r->org_z, v->surface.origin.z, sizeof r->org_z);
}

/* Samples the only light of a plan, without a choice. */
static void sample_only_light(const struct path_context *c, const struct path_packet *p,
                              const struct path_vertex *v, struct light_selection *selection,
                              struct nee_sample *out)
{
    const struct light *light = &c->lights->lights[0];
    const float *color = light->plan->color;
    c->kernels->path_pairs(p, PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_LIGHT, selection->u,
                           selection->v);
    c->light_kernels->sample_light(light, selection->u, selection->v, &v->surface, &v->active,
                                   &out->packet);
    for (int i = 0; i < LANES; i++) {
        selection->probability[i] = 1.0f;
        selection->soft[i] = 0.0f;
        out->color.x[i] = color[0];
        out->color.y[i] = color[1];
        out->color.z[i] = color[2];
    }
}

static void sample_lights(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct light_selection *selection,
                          struct nee_sample *out)
{
    if (is_one_light(c->lights)) {
        sample_only_light(c, p, v, selection, out);
        return;
    }
    memset(&out->packet.traced, 0, sizeof out->packet.traced);
    choose(c, p, v, selection);
    if (selection->plan_lights) sample_plan_lights(c, v, selection, out);
    if (selection->others) sample_others(c, v, selection, out);
    finish_rays(v, &out->packet.rays.ray);
    finish_colors(c, selection, out);
}

/* The radiance that the vertex reflects of the sample if it is visible, over the throughput. */
struct reflected {
    struct lanes3 diffuse; /* albedo taken out */
    struct lanes3 all;
};

static void reflect_general(const struct path_vertex *v, const struct light_selection *selection,
                            const struct nee_sample *l, int i, struct reflected *out)
{
    const struct RTCRay16 *r = &l->packet.rays.ray;
    const struct bsdf *b = &v->bsdf[i];
    float d[3] = {r->dir_x[i], r->dir_y[i], r->dir_z[i]};
    float squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    float scale = 1.0f / sqrtf(squared > 0.0f ? squared : 1.0f);
    float wi[3];
    path_to_frame(v, i, d, wi);
    for (int k = 0; k < 3; k++) wi[k] *= scale;
    float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]};
    struct bsdf_value value;
    bsdf_evaluate(b, wo, wi, &value);
    float density = l->packet.density[i] * selection->probability[i];
    float ratio = density > 0.0f ? value.pdf / density : 0.0f;
    float e = l->packet.irradiance[i] / (1.0f + ratio * ratio);
    const float color[3] = {l->color.x[i], l->color.y[i], l->color.z[i]};
    float all[3];
    for (int k = 0; k < 3; k++)
        all[k] = (b->albedo[k] * value.diffuse + value.specular[k]) * e * color[k];
    out->diffuse.x[i] = value.diffuse * e * color[0];
    out->diffuse.y[i] = value.diffuse * e * color[1];
    out->diffuse.z[i] = value.diffuse * e * color[2];
    out->all.x[i] = all[0];
    out->all.y[i] = all[1];
    out->all.z[i] = all[2];
}

static bool is_alone(const struct path_vertex *v, int i)
{
    return !v->lambert.on[i] && !v->layers.on.on[i];
}

static void reflect(const struct path_context *c, const struct path_vertex *v,
                    const struct light_selection *selection, const struct nee_sample *l,
                    struct reflected *out)
{
    const struct surface *s = &v->surface;
    if (!v->any_lambert) memset(out, 0, sizeof *out);
    if (v->any_lambert) {
        c->kernels->lambert_light(l, s, selection->probability, &out->diffuse);
        for (int i = 0; i < LANES; i++) {
            out->all.x[i] = out->diffuse.x[i] * s->albedo.x[i];
            out->all.y[i] = out->diffuse.y[i] * s->albedo.y[i];
            out->all.z[i] = out->diffuse.z[i] * s->albedo.z[i];
        }
    }
    if (!v->any_general) return;
    if (v->layers.any)
        c->kernels->layers_light(l, v, selection->probability, &out->diffuse, &out->all);
    for (int i = 0; v->layers.others && i < LANES; i++)
        if (l->packet.traced.on[i] && is_alone(v, i)) reflect_general(v, selection, l, i, out);
}

/* Leaves the soft share of the sky to the fields that light the camera path's first surface: the
 * diffuse lobe's, and the glossy lobe's if they light that, too. On other surfaces that share
 * becomes the diffuse part. */
static void leave_soft(const struct path_packet *p, const struct path_vertex *v,
                       const struct light_selection *selection, const struct path_harvest *h,
                       struct reflected *f)
{
    const struct lanes3 *a = &v->surface.albedo;
    struct lanes3 *d = &f->diffuse, *all = &f->all;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        const bool own = h->own[slot] > 0.0f;
        const bool lobe = h->lobe.r[slot] + h->lobe.g[slot] + h->lobe.b[slot] > 0.0f;
        const float soft = selection->soft[i], rest = lobe ? 1.0f - soft : 1.0f;
        const float left = own || lobe ? 0.0f : soft, found = own ? soft : 0.0f;
        all->x[i] = fmaxf(rest * all->x[i] - left * (d->x[i] * a->x[i]), 0.0f);
        all->y[i] = fmaxf(rest * all->y[i] - left * (d->y[i] * a->y[i]), 0.0f);
        all->z[i] = fmaxf(rest * all->z[i] - left * (d->z[i] * a->z[i]), 0.0f);
        d->x[i] *= found;
        d->y[i] *= found;
        d->z[i] *= found;
    }
}

/* Records the only path's sample. */
PATH_RECORD_COLD static void record(const struct path_context *c, const struct path_vertex *v,
                                    const struct light_selection *selection,
                                    const struct light_packet *l, const struct reflected *f)
{
    const float all[3] = {f->all.x[0], f->all.y[0], f->all.z[0]};
    const uint32_t light = is_one_light(c->lights) ? 0 : selection->chosen[0];
    path_record_light(c, v, light, selection->probability[0], l, all);
}

/* Drops the rays whose light would not be reflected. */
static void drop_dim(const struct path_context *c, const struct reflected *f,
                     struct light_packet *p)
{
    uint32_t dim = 0;
    for (int i = 0; i < LANES; i++) {
        int32_t bright = -(f->all.x[i] + f->all.y[i] + f->all.z[i] > 0.0f);
        dim += (uint32_t)(p->traced.on[i] & ~bright & 1);
        p->traced.on[i] &= bright;
    }
    c->counters->value[COUNTER_SKIPPED_DIM_LIGHT] += dim;
}

static void gather(const struct path_context *c, const struct path_packet *p,
                   const struct path_vertex *v, const struct light_packet *l,
                   const struct reflected *f, struct path_harvest *h)
{
    const struct lanes3 *t = &p->throughput;
    struct lanes_mask lit;
    struct lanes3 value;
    for (int i = 0; i < LANES; i++) {
        lit.on[i] = l->traced.on[i] & ~-(l->rays.ray.tfar[i] < 0.0f); /* not occluded */
        value.x[i] = f->all.x[i] * t->x[i];
        value.y[i] = f->all.y[i] * t->y[i];
        value.z[i] = f->all.z[i] * t->z[i];
    }
    path_harvest_add_lanes(c, h, v->depth + 1, p, &lit, &value);
    for (uint32_t i = 0; c->demodulate && v->depth == 0 && i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!lit.on[i]) continue;
        h->diffuse_direct.r[slot] += f->diffuse.x[i];
        h->diffuse_direct.g[slot] += f->diffuse.y[i];
        h->diffuse_direct.b[slot] += f->diffuse.z[i];
    }
}

/* What samples of the sky are from, of each surface. */
static void find_tables(const struct path_context *c, struct path_vertex *v)
{
    const struct surface *s = &v->surface;
    for (int i = 0; i < LANES; i++) {
        const float normal[3] = {s->normal.x[i], s->normal.y[i], s->normal.z[i]};
        v->sky_table[i] = v->active.on[i]
                              ? sky_guide_table(c->sky->guide, s->position.x[i], s->position.y[i],
                                                s->position.z[i], normal)
                              : 0;
    }
}

void path_nee_add(const struct path_context *c, const struct path_packet *p, struct path_vertex *v,
                  struct nee_sample *light, struct path_harvest *h)
{
    struct light_selection selection;
    struct reflected reflected;
    struct light_packet *packet = &light->packet;
    if (c->sky->guide) find_tables(c, v);
    sample_lights(c, p, v, &selection, light);
    if (c->blended) c->kernels->ray_keys(p, v->depth, PATH_RAY_SHADOW, &packet->rays.ray);
    light_count_skips(packet, &v->active, 1, c->counters);
    for (int i = 0; i < LANES; i++) /* scattering will not find the light of the last vertex */
        packet->density[i] = v->last.on[i] ? 0.0f : packet->density[i];
    reflect(c, v, &selection, light, &reflected);
    if (c->leaves_sky && v->depth == 0) leave_soft(p, v, &selection, h, &reflected);
    drop_dim(c, &reflected, packet);
    queries_sanitise(c->queries, &packet->traced, &packet->rays.ray);
    if (c->record) record(c, v, &selection, packet, &reflected);
    uint32_t traced = lanes_count(&packet->traced);
    if (traced == 0) return;
    c->counters->value[v->depth == 0 ? COUNTER_RAYS_SHADOW : COUNTER_RAYS_INDIRECT_SHADOW] +=
        traced;
    queries_occluded(c->queries, v->depth == 0 ? QUERY_SHADOW : QUERY_BOUNCE_SHADOW,
                     &packet->traced, &packet->rays);
    if (c->record) path_record_shadow(c, p, packet);
    gather(c, p, v, packet, &reflected, h);
}
