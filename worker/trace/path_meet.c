/* What a path's ray meets that shines by itself. */
#include <math.h>

#include "worker/scene/emitters.h"
#include "worker/trace/lane_kernels.h"
#include "worker/trace/path_record.h"

/* The power heuristic, as path_lanes.h has it. */
static float weigh(float own, float other)
{
    if (!(own > 0.0f)) return 1.0f;
    float ratio = other / own;
    return 1.0f / (1.0f + ratio * ratio);
}

static void add(const struct path_context *c, const struct path_packet *p, uint32_t depth,
                uint32_t i, const float radiance[3], float weight, struct path_harvest *h)
{
    const struct lanes3 *t = &p->throughput;
    float value[3] = {radiance[0] * weight * t->x[i], radiance[1] * weight * t->y[i],
                      radiance[2] * weight * t->z[i]};
    uint32_t slot = p->slot[i];
    if (depth > 0) {
        path_harvest_add(c, h, depth, slot, value);
        return;
    }
    h->emission.r[slot] += value[0];
    h->emission.g[slot] += value[1];
    h->emission.b[slot] += value[2];
}

static void meet_sky(const struct path_context *c, const struct path_packet *p,
                     const struct path_vertex *v, struct path_harvest *h)
{
    const struct RTCRay16 *r = &p->rays.ray;
    for (uint32_t i = 0; i < p->count; i++) {
        if (v->surface.hit.on[i]) continue;
        float direction[3] = {r->dir_x[i], r->dir_y[i], r->dir_z[i]}, radiance[3], weight = 1.0f;
        sky_radiance(c->sky, direction, radiance);
        if (c->sky->kind == ENVIRONMENT_MAP && p->pdf[i] > 0.0f)
            weight =
                weigh(p->pdf[i], c->lights->environment_probability * sky_pdf(c->sky, direction));
        if (c->record) path_record_meet(c, p, LIGHT_CHOICE_ENVIRONMENT, radiance, weight);
        add(c, p, v->depth, i, radiance, weight, h);
    }
}

/* Where rays end for rectangles: at what they hit, and a little beyond where that is the geometry
 * of an emitter, whose rectangle stands for it. */
static void find_reach(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, float reach[LANES])
{
    float clearance = 0.0f;
    for (uint32_t k = 0; k < c->lights->count; k++)
        clearance = fmaxf(clearance, c->lights->lights[k].clearance);
    for (int i = 0; i < LANES; i++) {
        const struct surface *s = &v->surface;
        const struct RTCRay16 *r = &p->rays.ray;
        reach[i] = s->hit.on[i] ? s->distance[i] : INFINITY;
        if (!(s->hit.on[i] & s->light.on[i])) continue;
        float cosine = -(s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] +
                         s->facet.z[i] * r->dir_z[i]);
        reach[i] += 2.0f * clearance / fmaxf(cosine, 1e-3f);
    }
}

static void meet_rectangles(const struct path_context *c, const struct path_packet *p,
                            const struct path_vertex *v, struct path_harvest *h)
{
    _Alignas(LANES_ALIGN) float reach[LANES], factor[LANES];
    bool ready = false;
    for (uint32_t k = 0; k < c->lights->count; k++) {
        const struct light *light = &c->lights->lights[k];
        if (light->plan->type != LIGHT_RECTANGLE) continue;
        if (!ready) find_reach(c, p, v, reach);
        ready = true;
        c->queries->kernels->meet_rectangle(light, p, reach, factor);
        for (uint32_t i = 0; i < p->count; i++)
            if (factor[i] > 0.0f) add(c, p, v->depth, i, light->plan->color, factor[i], h);
        if (c->record && factor[0] > 0.0f) path_record_meet(c, p, k, light->plan->color, factor[0]);
    }
}

/* Density per solid angle with which a light sample finds this point of a mesh emitter. */
static float emitter_density(const struct path_context *c, const struct path_packet *p,
                             const struct surface *s, uint32_t i)
{
    const struct RTCRay16 *r = &p->rays.ray;
    float area = emitters_pdf_area(c->queries->scene->emitters, s->id[i] - 1);
    float cosine =
        -(s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] + s->facet.z[i] * r->dir_z[i]);
    return c->lights->emitters_probability * area * s->distance[i] * s->distance[i] /
           fmaxf(cosine, 1e-12f);
}

static void meet_surfaces(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct path_harvest *h)
{
    const struct surface *s = &v->surface;
    for (uint32_t i = 0; i < p->count; i++) {
        float radiance[3] = {s->emission.x[i], s->emission.y[i], s->emission.z[i]}, weight = 1.0f;
        if (!s->hit.on[i] || !(radiance[0] + radiance[1] + radiance[2] > 0.0f)) continue;
        if (s->light.on[i] && v->depth > 0) continue; /* its rectangle has been met */
        if (p->pdf[i] > 0.0f && c->lights->emitters_probability > 0.0f)
            weight = weigh(p->pdf[i], emitter_density(c, p, s, i));
        if (c->record) path_record_meet(c, p, LIGHT_CHOICE_EMITTERS, radiance, weight);
        add(c, p, v->depth, i, radiance, weight, h);
    }
}

/* What the light field's first rays meet is direct light, which the plan's lights or its paths
 * (those of the lens, too) bring; but for surfaces that no light stands for where there are no
 * paths. */
static void meet_unlisted(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct path_harvest *h)
{
    const struct surface *s = &v->surface;
    if (c->plan->paths.spp > 0 || c->plan->lens_light == LENS_LIGHT_INDIRECT) return;
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t slot = p->slot[i];
        if (!s->hit.on[i] || s->light.on[i]) continue;
        h->indirect.r[slot] += s->emission.x[i] * p->throughput.x[i];
        h->indirect.g[slot] += s->emission.y[i] * p->throughput.y[i];
        h->indirect.b[slot] += s->emission.z[i] * p->throughput.z[i];
    }
}

void path_meet(const struct path_context *c, const struct path_packet *p,
               const struct path_vertex *v, struct path_harvest *h)
{
    if (c->field && v->depth == PATH_FIELD_DEPTH) {
        meet_unlisted(c, p, v, h);
        return;
    }
    if (c->sky->kind != ENVIRONMENT_NONE) meet_sky(c, p, v, h);
    if (v->depth > 0) meet_rectangles(c, p, v, h);
    meet_surfaces(c, p, v, h);
}
