/* Next-event estimation: what vertices reflect of light samples, and their shadow rays. */
#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/emitters.h"
#include "worker/shade/glossy.h"
#include "worker/trace/path/chains.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_nee.h"
#include "worker/trace/path/path_record.h"

/* Light samples of a camera path's first surface, of which one is traced. psnr_db at 4 samples of
 * Veach's plates, helmet in the studio, helmet in the park: 1: 32.6, 33.9, 36.8; 2: 35.3, 34.6,
 * 37.4; 4: 36.0, 34.9, 37.7; 8: 36.4, 35.1, 37.9. Four cost a seventh to a third of tracing. */
#define TRIES 4u

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
    if (v->is_far) wi[2] = -wi[2]; /* its frame is the near side's but for the normal */
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
                       const struct light_selection *selection, const struct path_radiance *h,
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

/* The same where no lens is: of that share all is left that the field of glossy lobes brings, too,
 * else the diffuse lobe's part. */
static void leave_soft_field(const struct path_context *c, const struct path_packet *p,
                             const struct path_vertex *v, const struct light_selection *selection,
                             struct reflected *f)
{
    const struct lanes3 *a = &v->surface.albedo;
    struct lanes3 *d = &f->diffuse, *all = &f->all;
    for (uint32_t i = 0; i < p->count; i++) {
        const bool lobe = (c->skip & SKIP_GLOSSY_INDIRECT) && v->active.on[i] &&
                          !v->lambert.on[i] && glossy_has(&v->bsdf[i]);
        const float soft = selection->soft[i], rest = lobe ? 1.0f - soft : 1.0f;
        const float left = lobe ? 0.0f : soft;
        all->x[i] = fmaxf(rest * all->x[i] - left * (d->x[i] * a->x[i]), 0.0f);
        all->y[i] = fmaxf(rest * all->y[i] - left * (d->y[i] * a->y[i]), 0.0f);
        all->z[i] = fmaxf(rest * all->z[i] - left * (d->z[i] * a->z[i]), 0.0f);
        d->x[i] *= 1.0f - soft;
        d->y[i] *= 1.0f - soft;
        d->z[i] *= 1.0f - soft;
    }
}

static void leave_sky(const struct path_context *c, const struct path_packet *p,
                      const struct path_vertex *v, const struct light_selection *selection,
                      const struct path_radiance *h, struct reflected *f)
{
    if (v->depth > 0) return;
    if (c->skip & SKIP_SOFT_SKY) leave_soft(p, v, selection, h, f);
    if (c->skip & SKIP_SKY_FIELD) leave_soft_field(c, p, v, selection, f);
}

/* Leaves direct light of the plan's lights, as diffuse lobes reflect it, to fields. */
static void leave_listed(const struct path_context *c, const struct path_vertex *v,
                         const struct light_selection *selection, struct reflected *f)
{
    const struct lanes3 *a = &v->surface.albedo;
    struct lanes3 *d = &f->diffuse, *all = &f->all;
    if (!(c->skip & SKIP_LISTED) || v->depth > 0) return;
    for (int i = 0; i < LANES; i++) {
        if (!v->left.on[i] || selection->chosen[i] >= LIMIT_LIGHTS) continue;
        all->x[i] = fmaxf(all->x[i] - d->x[i] * a->x[i], 0.0f);
        all->y[i] = fmaxf(all->y[i] - d->y[i] * a->y[i], 0.0f);
        all->z[i] = fmaxf(all->z[i] - d->z[i] * a->z[i], 0.0f);
        d->x[i] = d->y[i] = d->z[i] = 0.0f;
    }
}

/* Records the only path's sample. */
PATH_RECORD_COLD static void record(const struct path_context *c, const struct path_vertex *v,
                                    const struct light_selection *selection,
                                    const struct light_packet *l, const struct reflected *f)
{
    const float all[3] = {f->all.x[0], f->all.y[0], f->all.z[0]};
    const uint32_t chosen = selection->chosen[0];
    const bool mesh = chosen >= LIGHT_CHOICE_EMITTERS && chosen < LIGHT_CHOICE_ENVIRONMENT;
    const uint32_t light = mesh ? LIGHT_CHOICE_EMITTERS : chosen;
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
                   const struct reflected *f, struct path_radiance *h)
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
    path_radiance_add_lanes(c, h, v->depth + 1, p, &lit, &value);
    for (uint32_t i = 0; c->demodulate && v->depth == 0 && i < p->count; i++) {
        const uint32_t slot = p->slot[i];
        if (!lit.on[i]) continue;
        h->diffuse_direct.r[slot] += f->diffuse.x[i];
        h->diffuse_direct.g[slot] += f->diffuse.y[i];
        h->diffuse_direct.b[slot] += f->diffuse.z[i];
    }
    if (c->chains && v->depth > 0) chains_gather(c, p, v, &lit, &f->diffuse, h);
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

/* One sample of lights, and what is reflected of it if it is visible. */
static void try_lights(const struct path_context *c, struct path_numbers n,
                       const struct path_vertex *v, struct light_selection *selection,
                       struct nee_sample *light, struct reflected *out)
{
    struct light_packet *packet = &light->packet;
    path_nee_sample(c, n, v, selection, light);
    light_count_skips(packet, &v->active, 1, c->counters);
    for (int i = 0; i < LANES; i++) /* scattering will not find the light of the last vertex */
        packet->density[i] = v->last.on[i] ? 0.0f : packet->density[i];
    reflect(c, v, selection, light, out);
    leave_listed(c, v, selection, out);
}

/* Of several samples, one is traced: chosen in proportion to what it would bring. */
struct reservoir {
    _Alignas(LANES_ALIGN) float sum[LANES], own[LANES]; /* luminances of all, of the chosen one */
    _Alignas(LANES_ALIGN) float choice[LANES];
};

static void take_lane(const struct nee_sample *from, const struct light_selection *selected,
                      const struct reflected *brings, int i, struct nee_sample *to,
                      struct light_selection *selection, struct reflected *out)
{
    light_take_lane(&from->packet, i, &to->packet);
    to->color.x[i] = from->color.x[i];
    to->color.y[i] = from->color.y[i];
    to->color.z[i] = from->color.z[i];
    selection->chosen[i] = selected->chosen[i];
    selection->probability[i] = selected->probability[i];
    selection->soft[i] = selected->soft[i];
    out->all.x[i] = brings->all.x[i];
    out->all.y[i] = brings->all.y[i];
    out->all.z[i] = brings->all.z[i];
    out->diffuse.x[i] = brings->diffuse.x[i];
    out->diffuse.y[i] = brings->diffuse.y[i];
    out->diffuse.z[i] = brings->diffuse.z[i];
}

static float brings(const struct nee_sample *l, const struct reflected *f, int i)
{
    const float sum = 0.2126f * f->all.x[i] + 0.7152f * f->all.y[i] + 0.0722f * f->all.z[i];
    return l->packet.traced.on[i] && sum > 0.0f && sum < INFINITY ? sum : 0.0f;
}

static void scale_lane(float by, int i, struct reflected *f)
{
    f->all.x[i] *= by;
    f->all.y[i] *= by;
    f->all.z[i] *= by;
    f->diffuse.x[i] *= by;
    f->diffuse.y[i] *= by;
    f->diffuse.z[i] *= by;
}

/* Takes TRIES samples and keeps one of them, in proportion to its luminance f before visibility;
 * what it brings is to be scaled by the mean of f over its own (Talbot, Cline and Egbert 2005,
 * "Importance Resampling for Global Illumination"). All samples of a pixel's tries make one
 * sequence. */
static void try_several(const struct path_context *c, const struct path_packet *p,
                        const struct path_vertex *v, struct light_selection *selection,
                        struct nee_sample *light, struct nee_sample *tried, struct reflected *out,
                        float scale[LANES])
{
    struct light_selection selected;
    struct reflected next;
    struct reservoir r;
    uint32_t sample[LANES];
    _Alignas(LANES_ALIGN) float unused[LANES];
    const struct path_numbers n = {p->key, sample};
    c->kernels->path_pairs(p, PATH_PRODUCT, r.choice, unused);
    for (int i = 0; i < LANES; i++) sample[i] = p->sample[i] * TRIES;
    try_lights(c, n, v, selection, light, out);
    for (int i = 0; i < LANES; i++) r.sum[i] = r.own[i] = brings(light, out, i);
    for (uint32_t k = 1; k < TRIES; k++) {
        for (int i = 0; i < LANES; i++) sample[i]++;
        try_lights(c, n, v, &selected, tried, &next);
        for (int i = 0; i < LANES; i++) {
            const float own = brings(tried, &next, i);
            if (!(own > 0.0f)) continue;
            r.sum[i] += own;
            const float share = own / r.sum[i], at = r.choice[i];
            const bool takes = at < share;
            r.choice[i] = takes ? at / share : (at - share) / (1.0f - share);
            if (!takes) continue;
            r.own[i] = own;
            take_lane(tried, &selected, &next, i, light, selection, out);
        }
    }
    for (int i = 0; i < LANES; i++)
        scale[i] = r.own[i] > 0.0f ? r.sum[i] / ((float)TRIES * r.own[i]) : 1.0f;
}

/* Traces the rays of a sample and adds what comes along them. */
static void trace_sample(const struct path_context *c, const struct path_packet *p,
                         const struct path_vertex *v, const struct light_selection *selection,
                         struct nee_sample *light, struct reflected *reflected,
                         struct path_radiance *h)
{
    struct light_packet *packet = &light->packet;
    const bool camera = v->depth == 0;
    if (c->blended) c->kernels->ray_keys(p, v->depth, PATH_RAY_SHADOW, &packet->rays.ray);
    memcpy(packet->rays.ray.time, p->rays.ray.time, sizeof packet->rays.ray.time);
    drop_dim(c, reflected, packet);
    queries_sanitise(c->queries, &packet->traced, &packet->rays.ray);
    if (c->record) record(c, v, selection, packet, reflected);
    const uint32_t traced = lanes_count(&packet->traced);
    if (traced == 0) return;
    c->counters->value[camera ? COUNTER_RAYS_SHADOW : COUNTER_RAYS_INDIRECT_SHADOW] += traced;
    queries_occluded(c->queries, camera ? QUERY_SHADOW : QUERY_BOUNCE_SHADOW, &packet->traced,
                     &packet->rays);
    if (c->record) path_record_shadow(c, p, packet);
    gather(c, p, v, packet, reflected, h);
}

/* Adds a sample of each light without extent. */
static void add_points(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v, struct nee_sample *light,
                       struct path_radiance *h)
{
    struct light_selection selection;
    struct reflected reflected;
    for (uint32_t k = 0; k < c->lights->count; k++) {
        if (!light_is_point(&c->lights->lights[k])) continue;
        path_nee_sample_point(c, &c->lights->lights[k], v, &selection, light);
        light_count_skips(&light->packet, &v->active, 1, c->counters);
        reflect(c, v, &selection, light, &reflected);
        leave_listed(c, v, &selection, &reflected);
        leave_sky(c, p, v, &selection, h, &reflected);
        trace_sample(c, p, v, &selection, light, &reflected, h);
    }
}

void path_nee_add(const struct path_context *c, const struct path_packet *p, struct path_vertex *v,
                  struct nee_sample light[2], struct path_radiance *h)
{
    struct light_selection selection;
    struct reflected reflected;
    float scale[LANES];
    const bool choice = !light_table_is_single(c->lights), several = choice && v->depth == 0;
    if (c->sky->guide) find_tables(c, v);
    if (choice) light_choice_weigh(c, v);
    if (light_table_takes_points(c->lights, v->depth)) {
        add_points(c, p, v, light, h);
        if (!light_table_has_extended(c->lights)) return;
    }
    if (several)
        try_several(c, p, v, &selection, &light[0], &light[1], &reflected, scale);
    else
        try_lights(c, (struct path_numbers){p->key, p->sample}, v, &selection, light, &reflected);
    /* Before scaling, which rounds what is left of nothing. */
    leave_sky(c, p, v, &selection, h, &reflected);
    for (int i = 0; several && i < LANES; i++) scale_lane(scale[i], i, &reflected); /* 0 stays 0 */
    trace_sample(c, p, v, &selection, light, &reflected, h);
}
