/* Samples one point of one light for every vertex. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/emitters.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_nee.h"

/* Shadow rays end just short of a mesh emitter's point, beside the offset of the point itself. */
#define EMITTER_END 0.9999f

static float probability_of(const struct light_table *t, uint32_t chosen)
{
    if (chosen == LIGHT_CHOICE_EMITTERS) return t->emitters_probability;
    if (chosen == LIGHT_CHOICE_ENVIRONMENT) return t->environment_probability;
    return t->lights[chosen].probability;
}

static void choose(const struct path_context *c, struct path_numbers n, const struct path_vertex *v,
                   struct light_selection *out)
{
    const struct path_kernels *kernels = c->kernels;
    const uint32_t base = PATH_VERTEX + v->depth * PATH_PER_VERTEX;
    _Alignas(LANES_ALIGN) float lobe[LANES], which[LANES], unused[LANES];
    out->plan_lights = 0;
    out->others = false;
    kernels->path_pairs_of(n.key, n.sample, base + PATH_LIGHT, out->u, out->v);
    kernels->path_pairs_of(n.key, n.sample, base + PATH_CHOICE, lobe, which);
    kernels->path_pairs_of(n.key, n.sample, base + PATH_ROULETTE, unused, out->pick);
    for (int i = 0; i < LANES; i++) {
        out->chosen[i] = UINT32_MAX;
        out->soft[i] = 0.0f;
        out->probability[i] = 1.0f;
        if (!v->active.on[i]) continue;
        uint32_t chosen = light_table_choose(c->lights, which[i]);
        out->chosen[i] = chosen;
        out->probability[i] = probability_of(c->lights, chosen);
        out->which[i] = which[i];
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
    const float chance = choose_group(&v->groups, emitters_groups(emitters)->count, i,
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
    const struct vector start = surface_start(s, i, way[0], way[1], way[2]);
    r->dir_x[i] = e.position[0] + clear * e.normal[0] - start.x;
    r->dir_y[i] = e.position[1] + clear * e.normal[1] - start.y;
    r->dir_z[i] = e.position[2] + clear * e.normal[2] - start.z;
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
    for (int i = 0; i < LANES; i++) {
        const struct vector start =
            surface_start(&v->surface, i, r->dir_x[i], r->dir_y[i], r->dir_z[i]);
        r->org_x[i] = start.x;
        r->org_y[i] = start.y;
        r->org_z[i] = start.z;
    }
}

/* Samples the only light of a plan, without a choice. */
static void sample_only_light(const struct path_context *c, struct path_numbers n,
                              const struct path_vertex *v, struct light_selection *selection,
                              struct nee_sample *out)
{
    const struct light *light = &c->lights->lights[0];
    const float *color = light->plan->color;
    c->kernels->path_pairs_of(n.key, n.sample,
                              PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_LIGHT, selection->u,
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

void path_nee_sample(const struct path_context *c, struct path_numbers n,
                     const struct path_vertex *v, struct light_selection *selection,
                     struct nee_sample *out)
{
    if (path_nee_one_light(c->lights)) {
        sample_only_light(c, n, v, selection, out);
        return;
    }
    memset(&out->packet.traced, 0, sizeof out->packet.traced);
    choose(c, n, v, selection);
    if (selection->plan_lights) sample_plan_lights(c, v, selection, out);
    if (selection->others) sample_others(c, v, selection, out);
    finish_rays(v, &out->packet.rays.ray);
    finish_colors(c, selection, out);
}
