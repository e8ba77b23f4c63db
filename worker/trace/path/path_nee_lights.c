/* Samples one point of one light for every vertex. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/alias_table.h"
#include "worker/scene/emitters.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_nee.h"

/* Shadow rays end just short of a mesh emitter's point, beside the offset of the point itself. */
#define EMITTER_END 0.9999f

/* The largest float below 1. */
#define BELOW_ONE 0x1.fffffep-1f

static void draw(const struct path_context *c, struct path_numbers n, const struct path_vertex *v,
                 struct light_selection *out)
{
    const struct path_kernels *kernels = c->kernels;
    const uint32_t base = PATH_VERTEX + v->depth * PATH_PER_VERTEX;
    _Alignas(LANES_ALIGN) float unused[LANES];
    kernels->path_pairs_of(n.key, n.sample, base + PATH_LIGHT, out->u, out->v);
    kernels->path_pairs_of(n.key, n.sample, base + PATH_CHOICE, unused, out->which);
    kernels->path_pairs_of(n.key, n.sample, base + PATH_ROULETTE, unused, out->pick);
}

/* Takes the environment out of the choice, which has the last part of [0, 1). The rest is spread
 * over all of it. */
static void choose_sky(const struct path_vertex *v, struct light_selection *out)
{
    for (int i = 0; i < LANES; i++) {
        const float others = 1.0f - v->sky_share[i];
        const float x = out->which[i] / (others > 0.0f ? others : 1.0f);
        out->chosen[i] = out->which[i] < others ? UINT32_MAX : LIGHT_CHOICE_ENVIRONMENT;
        out->which[i] = x < 1.0f ? x : BELOW_ONE;
    }
}

/* Notes what lane i has chosen. */
static void take_choice(const struct path_vertex *v, int i, struct light_selection *out)
{
    const float share = v->sky_share[i];
    const bool sky = out->chosen[i] == LIGHT_CHOICE_ENVIRONMENT;
    const uint32_t chosen = sky ? LIGHT_CHOICE_ENVIRONMENT : out->choice.chosen[i];
    out->soft[i] = 0.0f;
    out->probability[i] = sky ? share : 1.0f;
    out->chosen[i] = v->active.on[i] ? chosen : UINT32_MAX;
    if (!v->active.on[i]) return;
    if (chosen < LIGHT_CHOICE_ENVIRONMENT)
        out->probability[i] =
            light_choice_probability(out->choice.weight[i], v->weights.total[i], share);
    if (chosen < LIMIT_LIGHTS)
        out->plan_lights |= UINT64_C(1) << chosen;
    else
        out->others = true;
}

static void choose(const struct path_context *c, struct path_numbers n, const struct path_vertex *v,
                   struct light_selection *out)
{
    draw(c, n, v, out);
    choose_sky(v, out);
    c->kernels->choose_light(c->lights, &v->weights, out->which, &out->choice);
    out->plan_lights = 0;
    out->others = false;
    for (int i = 0; i < LANES; i++) take_choice(v, i, out);
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

/* Chooses a leaf in the group that lane i has chosen. */
static struct light_leaf choose_leaf(const struct path_context *c, const struct path_vertex *v,
                                     const struct light_selection *selection, int i)
{
    const struct light_choice *of = &selection->choice;
    const double x = alias_refine(selection->which[i], (float[]){selection->u[i], selection->v[i]});
    const double target = x * (double)v->weights.total[i] - (double)of->before[i];
    const double within = target / (double)of->weight[i], most = (double)BELOW_ONE;
    return light_choice_descend(c, &v->surface.origin, &v->surface.normal, i,
                                selection->chosen[i] - LIGHT_CHOICE_EMITTERS,
                                within > 0.0 ? (within < most ? within : most) : 0.0);
}

/* Aims lane i's ray at a point of an emitter. False: nothing comes from there. */
static bool aim_at(const struct path_vertex *v, int i, const struct emitter_point *e, float chance,
                   struct light_packet *p)
{
    const struct surface *s = &v->surface;
    struct RTCRay16 *r = &p->rays.ray;
    float way[3] = {e->position[0] - s->position.x[i], e->position[1] - s->position.y[i],
                    e->position[2] - s->position.z[i]};
    float squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    float front = -(way[0] * e->normal[0] + way[1] * e->normal[1] + way[2] * e->normal[2]);
    float side = front < 0.0f ? -1.0f : 1.0f;
    if (!path_nee_aim(v, i, way, sqrtf(squared), p)) return false;
    p->skip[i] = LIGHT_FACING_AWAY;
    if (front == 0.0f || (front < 0.0f && !e->double_sided)) return false;
    p->skip[i] = LIGHT_TRACED;
    /* front, and so squared, are positive here */
    p->density[i] = chance * e->pdf_area * squared * sqrtf(squared) / fabsf(front);
    p->irradiance[i] /= p->density[i];
    float clear = side * fminf(e->offset, 0.5f * fabsf(front));
    const struct vector start = surface_start(s, i, way[0], way[1], way[2]);
    r->dir_x[i] = e->position[0] + clear * e->normal[0] - start.x;
    r->dir_y[i] = e->position[1] + clear * e->normal[1] - start.y;
    r->dir_z[i] = e->position[2] + clear * e->normal[2] - start.z;
    r->tfar[i] = EMITTER_END;
    return true;
}

/* Points of emitters that lanes sample. */
struct emitter_choices {
    int lane[LANES], count;
    struct light_leaf leaf[LANES];
    uint32_t triangle[LANES];
};

/* Chooses triangles for the lanes that chose emitters. */
static void choose_triangles(const struct path_context *c, const struct path_vertex *v,
                             const struct light_selection *selection, struct light_packet *p,
                             struct emitter_choices *out)
{
    out->count = 0;
    for (int i = 0; i < LANES; i++) {
        const uint32_t chosen = selection->chosen[i];
        if (chosen < LIGHT_CHOICE_EMITTERS || chosen >= LIGHT_CHOICE_ENVIRONMENT) continue;
        const struct light_leaf leaf = choose_leaf(c, v, selection, i);
        p->skip[i] = LIGHT_FACING_AWAY;
        if (!(leaf.chance > 0.0f)) continue;
        out->lane[out->count] = i;
        out->leaf[out->count] = leaf;
        out->triangle[out->count++] =
            emitters_choose(c->queries->scene->emitters, leaf.leaf, selection->pick[i],
                            (float[]){selection->u[i], selection->v[i]});
    }
}

/* Returns whether the view has the point's mesh. */
static bool is_there(const struct path_context *c, const struct emitter_point *e)
{
    const struct query_view *view = c->queries->view;
    const struct scene *blob = c->queries->scene->blob;
    return !view || (instance_class(&blob->instances[e->instance]) & view->others) != 0;
}

/* Samples mesh emitters in the lanes that chose them. Each step is done for all lanes before the
 * next, since triangles are seldom in the cache. */
static void sample_emitters(const struct path_context *c, const struct path_vertex *v,
                            const struct light_selection *selection, struct nee_sample *out)
{
    struct emitter_choices choices;
    choose_triangles(c, v, selection, &out->packet, &choices);
    for (int k = 0; k < choices.count; k++) {
        const int i = choices.lane[k];
        const float u[2] = {selection->u[i], selection->v[i]};
        struct emitter_point e;
        emitters_sample(c->queries->scene->emitters, choices.leaf[k].leaf, choices.triangle[k], u,
                        &e);
        if (!is_there(c, &e)) continue;
        if (!aim_at(v, i, &e, choices.leaf[k].chance, &out->packet)) continue;
        out->color.x[i] = e.radiance[0];
        out->color.y[i] = e.radiance[1];
        out->color.z[i] = e.radiance[2];
    }
}

static void sample_others(const struct path_context *c, const struct path_vertex *v,
                          struct light_selection *selection, struct nee_sample *out)
{
    struct light_packet *p = &out->packet;
    path_nee_sample_sky(c, v, selection, out);
    if (c->lights->emitters) sample_emitters(c, v, selection, out);
    for (int i = 0; i < LANES; i++) {
        const uint32_t chosen = selection->chosen[i];
        if (chosen == UINT32_MAX) p->skip[i] = LIGHT_FACING_AWAY;
        if (chosen == UINT32_MAX || chosen < LIMIT_LIGHTS) continue;
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

/* Samples a light without a choice. */
static void sample_sure(const struct path_context *c, const struct light *light,
                        const struct path_vertex *v, struct light_selection *selection,
                        struct nee_sample *out)
{
    const float *color = light->plan->color;
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

static void sample_only_light(const struct path_context *c, struct path_numbers n,
                              const struct path_vertex *v, struct light_selection *selection,
                              struct nee_sample *out)
{
    c->kernels->path_pairs_of(n.key, n.sample,
                              PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_LIGHT, selection->u,
                              selection->v);
    for (int i = 0; i < LANES; i++) selection->chosen[i] = 0;
    sample_sure(c, &c->lights->lights[0], v, selection, out);
}

void path_nee_sample_point(const struct path_context *c, const struct light *light,
                           const struct path_vertex *v, struct light_selection *selection,
                           struct nee_sample *out)
{
    const uint32_t number = (uint32_t)(light - c->lights->lights);
    for (int i = 0; i < LANES; i++) {
        selection->chosen[i] = number;
        selection->u[i] = selection->v[i] = 0.5f; /* it has one point */
    }
    sample_sure(c, light, v, selection, out);
}

void path_nee_sample(const struct path_context *c, struct path_numbers n,
                     const struct path_vertex *v, struct light_selection *selection,
                     struct nee_sample *out)
{
    if (light_table_is_single(c->lights)) {
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
