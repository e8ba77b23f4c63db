/* Adds the emission that the rays of paths meet, of the environment, rectangles and surfaces. */
#include <math.h>
#include <string.h>

#include "worker/scene/emitters.h"
#include "worker/trace/path/mis.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_photograph.h"
#include "worker/trace/path/path_record.h"

static void add(const struct path_context *c, const struct path_packet *p, uint32_t depth,
                uint32_t i, const float radiance[3], float weight, struct path_radiance *h)
{
    const struct lanes3 *t = &p->throughput;
    float value[3] = {radiance[0] * weight * t->x[i], radiance[1] * weight * t->y[i],
                      radiance[2] * weight * t->z[i]};
    uint32_t slot = p->slot[i];
    if (depth > 0 && p->part[i] == PATH_PART_ARRIVING) return;
    if (depth > 0 && p->part[i] != PATH_PART_NONE) {
        path_part_add(h, (enum path_part)p->part[i], slot, value);
        return;
    }
    if (depth > 0) {
        path_radiance_add(c, h, depth, slot, value);
        return;
    }
    h->emission.r[slot] += value[0];
    h->emission.g[slot] += value[1];
    h->emission.b[slot] += value[2];
}

/* Leaves the soft share of the sky, as the diffuse lobe reflects it, to the fields that light the
 * camera path's first surface. On other surfaces that share is noted, over the albedo. */
static void leave_soft(const struct path_packet *p, uint32_t i, float soft, float weight,
                       float radiance[3], struct path_radiance *h)
{
    const struct lanes3 *t = &p->throughput;
    const uint32_t slot = p->slot[i];
    if (h->own[slot] > 0.0f) {
        const float found = soft * weight;
        h->diffuse_direct.r[slot] += radiance[0] * found * t->x[i] * h->share.r[slot];
        h->diffuse_direct.g[slot] += radiance[1] * found * t->y[i] * h->share.g[slot];
        h->diffuse_direct.b[slot] += radiance[2] * found * t->z[i] * h->share.b[slot];
        return;
    }
    radiance[0] *= 1.0f - soft * (1.0f - h->kept.r[slot]);
    radiance[1] *= 1.0f - soft * (1.0f - h->kept.g[slot]);
    radiance[2] *= 1.0f - soft * (1.0f - h->kept.b[slot]);
}

/* The same where no lens is: what other lobes reflect of that share is added. The rest of the light
 * is left for all lobes. */
static void leave_soft_field(const struct path_packet *p, uint32_t i, float soft, float weight,
                             float radiance[3], struct path_radiance *h)
{
    const struct lanes3 *t = &p->throughput;
    const uint32_t slot = p->slot[i];
    h->direct.r[slot] += radiance[0] * soft * weight * t->x[i] * h->kept.r[slot];
    h->direct.g[slot] += radiance[1] * soft * weight * t->y[i] * h->kept.g[slot];
    h->direct.b[slot] += radiance[2] * soft * weight * t->z[i] * h->kept.b[slot];
    for (int k = 0; k < 3; k++) radiance[k] *= 1.0f - soft;
}

/* Rays that met nothing, and the directions in which they see the sky. */
struct missed {
    uint32_t count;
    int ray[LANES];
    struct sky_view view;
};

static void find_missed(const struct path_context *c, const struct path_packet *p,
                        const struct path_vertex *v, struct missed *out)
{
    const struct RTCRay16 *r = &p->rays.ray;
    out->count = 0;
    for (int i = 0; i < (int)p->count; i++)
        if (!v->surface.hit.on[i]) out->ray[out->count++] = i;
    if (out->count == 0 || c->sky->kind != ENVIRONMENT_MAP) return;
    c->kernels->find_sky(c->sky, r->dir_x, r->dir_y, r->dir_z, &out->view);
    for (uint32_t k = 0; k < out->count; k++) sky_ask(c->sky, &out->view, out->ray[k]);
}

static void meet_sky(const struct path_context *c, const struct path_packet *p,
                     const struct path_vertex *v, struct path_radiance *h)
{
    struct missed missed;
    if (v->depth == 0 && c->queries->view) return; /* a photograph stands there */
    find_missed(c, p, v, &missed);
    for (uint32_t k = 0; k < missed.count; k++) {
        const int lane = missed.ray[k];
        const uint32_t i = (uint32_t)lane;
        float radiance[3], weight = 1.0f;
        const float soft = sky_radiance(c->sky, &missed.view, lane, radiance);
        if (c->sky->kind == ENVIRONMENT_MAP && p->pdf[i] > 0.0f)
            weight = mis_power_weight(
                p->pdf[i], p->sky_share[i] * sky_pdf(c->sky, &missed.view, lane, p->sky_table[i]));
        if ((c->skip & SKIP_SOFT_SKY) && v->depth == 1) leave_soft(p, i, soft, weight, radiance, h);
        if ((c->skip & SKIP_SKY_FIELD) && v->depth == 1)
            leave_soft_field(p, i, soft, weight, radiance, h);
        if (c->record) path_record_meet(c, p, LIGHT_CHOICE_ENVIRONMENT, radiance, weight);
        add(c, p, v->depth, i, radiance, weight, h);
    }
}

/* Returns whether the camera itself sees the point. It sees geometry only then, but rectangles in
 * mirrors. */
static bool is_seen(const struct path_vertex *v, uint32_t i)
{
    return v->depth == 0 && !(v->mirrors.any && v->mirrors.count[i] > 0);
}

/* Finds where rays end for rectangles: at what they hit, or a little beyond it where that is the
 * geometry for which an emitter's rectangle stands. */
static void find_reach(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, float reach[LANES])
{
    float clearance = 0.0f;
    for (uint32_t k = 0; k < c->lights->count; k++)
        clearance = fmaxf(clearance, c->lights->lights[k].clearance);
    const struct surface *s = &v->surface;
    const struct RTCRay16 *r = &p->rays.ray;
    for (int i = 0; i < LANES; i++) reach[i] = s->hit.on[i] ? s->distance[i] : INFINITY;
    if (lanes_count_both(&s->hit, &s->light) == 0) return;
    for (int i = 0; i < LANES; i++) {
        if (!(s->hit.on[i] & s->light.on[i])) continue;
        float cosine = -(s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] +
                         s->facet.z[i] * r->dir_z[i]);
        reach[i] += 2.0f * clearance / fmaxf(cosine, 1e-3f);
    }
}

/* Weighs what rays that have met a rectangle bring, which light samples may find, too. */
static void weigh_rectangle(const struct path_context *c, const struct path_packet *p,
                            const struct path_vertex *v, const struct path_radiance *h,
                            const struct light *light, const float *density, float *factor)
{
    const bool listed = (c->skip & SKIP_LISTED) && v->depth == 1;
    const bool single = light_table_is_single(c->lights);
    _Alignas(LANES_ALIGN) float weight[LANES];
    bool any = false;
    for (uint32_t i = 0; i < p->count; i++) any |= factor[i] > 0.0f && p->pdf[i] > 0.0f;
    if (!any) return;
    if (!single) c->kernels->weigh_rectangle(light, &p->from, &p->normal, weight);
    for (uint32_t i = 0; i < p->count; i++) {
        if (!(factor[i] > 0.0f && p->pdf[i] > 0.0f)) continue;
        if (listed) weight[i] *= h->listed[p->slot[i]];
        const float chosen =
            single ? 1.0f : light_choice_probability(weight[i], p->lights[i], p->sky_share[i]);
        factor[i] *= mis_power_weight(p->pdf[i], chosen * density[i]);
    }
}

/* Adds what the ray meets of a rectangle. Of what first surfaces send on of it fields may bring the
 * diffuse lobe's part. */
static void add_rectangle(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, uint32_t i, uint32_t light, float factor,
                          struct path_radiance *h)
{
    const float *color = c->lights->lights[light].plan->color;
    const struct lanes3 *t = &p->throughput;
    const uint32_t slot = p->slot[i];
    float rest[3] = {color[0], color[1], color[2]};
    if ((c->skip & SKIP_LISTED) && v->depth == 1 && !(h->own[slot] > 0.0f)) {
        rest[0] *= h->kept.r[slot], rest[1] *= h->kept.g[slot], rest[2] *= h->kept.b[slot];
        h->direct.r[slot] += rest[0] * factor * t->x[i];
        h->direct.g[slot] += rest[1] * factor * t->y[i];
        h->direct.b[slot] += rest[2] * factor * t->z[i];
    } else {
        add(c, p, v->depth, i, color, factor, h);
    }
    if (c->record) path_record_meet(c, p, light, rest, factor);
}

static void meet_rectangles(const struct path_context *c, const struct path_packet *p,
                            const struct path_vertex *v, struct path_radiance *h)
{
    _Alignas(LANES_ALIGN) float reach[LANES], factor[LANES], density[LANES];
    bool ready = false;
    for (uint32_t k = 0; k < c->lights->count; k++) {
        const struct light *light = &c->lights->lights[k];
        if (light->plan->type != LIGHT_RECTANGLE) continue;
        if (!ready) find_reach(c, p, v, reach);
        ready = true;
        c->kernels->meet_rectangle(light, p, reach, factor, density);
        for (uint32_t i = 0; i < p->count; i++)
            if (is_seen(v, i)) factor[i] = 0.0f;
        weigh_rectangle(c, p, v, h, light, density, factor);
        for (uint32_t i = 0; i < p->count; i++)
            if (factor[i] > 0.0f) add_rectangle(c, p, v, i, k, factor[i], h);
    }
}

/* Returns the density per solid angle with which light samples find a mesh emitter's point. */
static float emitter_density(const struct path_context *c, const struct path_packet *p,
                             const struct surface *s, uint32_t i)
{
    const struct RTCRay16 *r = &p->rays.ray;
    const struct emitters *emitters = c->queries->scene->emitters;
    const uint32_t instance = s->id[i] - 1;
    uint32_t leaf;
    float weight;
    if (!emitters_find(emitters, instance, p->rays.hit.primID[i], &leaf)) return 0.0f;
    const float chance = light_choice_chance(c, &p->from, &p->normal, (int)i, leaf, &weight);
    const float chosen = light_choice_probability(weight, p->lights[i], p->sky_share[i]);
    const float area = chance * emitters_density(emitters, instance, leaf);
    const float cosine =
        -(s->facet.x[i] * r->dir_x[i] + s->facet.y[i] * r->dir_y[i] + s->facet.z[i] * r->dir_z[i]);
    return chosen * area * s->distance[i] * s->distance[i] / fmaxf(cosine, 1e-12f);
}

static void meet_surfaces(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct path_radiance *h)
{
    const struct surface *s = &v->surface;
    if (!s->any_emission) return;
    const bool sampled = v->depth > 0 && c->lights->emitters;
    for (uint32_t i = 0; i < p->count; i++) {
        float radiance[3] = {s->emission.x[i], s->emission.y[i], s->emission.z[i]}, weight = 1.0f;
        if (!s->hit.on[i] || !(radiance[0] + radiance[1] + radiance[2] > 0.0f)) continue;
        if (s->light.on[i] && !is_seen(v, i)) continue; /* its rectangle has been met */
        if (sampled && p->pdf[i] > 0.0f)
            weight = mis_power_weight(p->pdf[i], emitter_density(c, p, s, i));
        if (c->record) path_record_meet(c, p, LIGHT_CHOICE_EMITTERS, radiance, weight);
        add(c, p, v->depth, i, radiance, weight, h);
    }
}

/* Adds the part of the sky that the light field's first rays meet and fields are to bring. */
static void meet_soft_sky(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct path_radiance *h)
{
    const struct lanes3 *t = &p->throughput;
    struct missed missed;
    find_missed(c, p, v, &missed);
    for (uint32_t k = 0; k < missed.count; k++) {
        const int i = missed.ray[k];
        const uint32_t slot = p->slot[i];
        float radiance[3];
        const float soft = sky_radiance(c->sky, &missed.view, i, radiance);
        h->indirect.r[slot] += soft * radiance[0] * t->x[i];
        h->indirect.g[slot] += soft * radiance[1] * t->y[i];
        h->indirect.b[slot] += soft * radiance[2] * t->z[i];
        if (c->record) path_record_meet(c, p, LIGHT_CHOICE_ENVIRONMENT, radiance, soft);
    }
}

/* Records the emission of the only path's surface. */
PATH_RECORD_COLD static void record_emission(const struct path_context *c,
                                             const struct path_packet *p, const struct surface *s)
{
    const float radiance[3] = {s->emission.x[0], s->emission.y[0], s->emission.z[0]};
    if (radiance[0] + radiance[1] + radiance[2] > 0.0f)
        path_record_meet(c, p, LIGHT_CHOICE_EMITTERS, radiance, 1.0f);
}

/* Adds the emission of surfaces that no light stands for, where there are no paths. All else that
 * the light field's first rays meet is direct light, which the plan's lights or its paths bring,
 * those of the lens, too. */
static void meet_unlisted(const struct path_context *c, const struct path_packet *p,
                          const struct path_vertex *v, struct path_radiance *h)
{
    const struct surface *s = &v->surface;
    const uint32_t lens = c->plan->lens_relight;
    if (plan_sky_in_fields(c->plan)) meet_soft_sky(c, p, v, h);
    const bool paths =
        c->plan->paths.spp > 0 && c->plan->paths.without_diffuse_direct != DIRECT_LEFT_ALL;
    if (paths || lens == LENS_RELIGHT_INDIRECT || lens == LENS_RELIGHT_SKY) return;
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t slot = p->slot[i];
        if (!s->hit.on[i] || s->light.on[i]) continue;
        h->indirect.r[slot] += s->emission.x[i] * p->throughput.x[i];
        h->indirect.g[slot] += s->emission.y[i] * p->throughput.y[i];
        h->indirect.b[slot] += s->emission.z[i] * p->throughput.z[i];
        if (c->record) record_emission(c, p, s);
    }
}

void path_emission_add(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, struct path_radiance *h)
{
    if (c->field && v->depth == PATH_FIELD_DEPTH) {
        meet_unlisted(c, p, v, h);
        return;
    }
    if ((c->skip & SKIP_DIFFUSE) && v->depth == 0) return;
    if (c->sky->kind != ENVIRONMENT_NONE) meet_sky(c, p, v, h);
    if ((c->skip & SKIP_LISTED) && v->depth == 0) return;
    if (v->depth > 0 || v->mirrors.any) meet_rectangles(c, p, v, h);
    meet_surfaces(c, p, v, h);
}
