#include "worker/trace/field/field_record.h"
#include "worker/trace/light/light_kernels.h"

#include <math.h>
#include <string.h>

#define INVERSE_PI 0.318309886183790672f

static void take(const struct lanes3 *from, uint32_t lane, float out[3])
{
    out[0] = from->x[lane];
    out[1] = from->y[lane];
    out[2] = from->z[lane];
}

void field_record_centre(struct path_record *record, const struct block *b,
                         const struct RTCRayHit16 *camera, const struct path_vertex *v)
{
    struct path_record_field *f = &record->field;
    struct path_record_vertex *to = &record->vertices[0];
    int lane = 0;
    while (lane < LANES - 1 && !b->kept.on[lane]) lane++;
    f->lane = (uint32_t)lane;
    f->mirrored = v->mirrors.any ? v->mirrors.count[lane] : 0;
    record->pixel[0] = (float)b->x_px[lane] + 0.5f;
    record->pixel[1] = (float)b->y_px[lane] + 0.5f;
    record->count = 1;
    f->seen = v->surface.hit.on[lane]; /* unless a stratum says something else */
    path_record_hit(camera, v, lane, to);
    path_record_reflect(v, lane, to);
    to->throughput[0] = to->throughput[1] = to->throughput[2] = 1.0f;
    if (f->mirrored > 0) take(&v->mirrors.tint, f->lane, to->throughput);
}

/* ---- lights ---- */

void field_record_hidden(struct path_record *record, const struct light_packet *packet)
{
    struct path_record_field *f = &record->field;
    struct path_record_light *to = &record->vertices[0].light;
    to->tried = true;
    to->light = f->light;
    to->skip = packet->skip[f->lane];
    f->hidden = true;
}

/* Where on the light: as light_lanes.h places it. */
static void find_point(const struct light *light, struct path_record_field *f)
{
    const struct plan_light *p = light->plan;
    const bool wide = p->type == LIGHT_RECTANGLE;
    const float a = wide ? 2.0f * f->u[0] - 1.0f : 0.0f, b = wide ? 2.0f * f->u[1] - 1.0f : 0.0f;
    f->has_point = p->type != LIGHT_DIRECTIONAL;
    for (int k = 0; k < 3; k++) f->point[k] = p->position[k] + a * p->half_u[k] + b * p->half_v[k];
}

static void take_ray(const struct light_packet *l, uint32_t i, struct path_record_light *to)
{
    const struct RTCRay16 *r = &l->rays.ray;
    const float way[3] = {r->dir_x[i], r->dir_y[i], r->dir_z[i]};
    const float squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    const float length = sqrtf(squared > 0.0f ? squared : 1.0f);
    memcpy(to->origin, (float[]){r->org_x[i], r->org_y[i], r->org_z[i]}, sizeof to->origin);
    for (int k = 0; k < 3; k++) to->direction[k] = way[k] / length;
    to->distance = l->end * length;
}

/* What the stratum adds to its row, and its bit and slope, by the kernels that sum strata up. */
static void add_stratum(const struct light_kernels *kernels, const struct light_packet *l,
                        bool slopes, struct path_record_field *f)
{
    struct shadow_sums one;
    kernels->add_strata(l, 0, 1, 2, &one); /* no end of a row */
    if (slopes) kernels->add_slopes(l, &one);
    f->arrives = one.row[f->lane];
    f->seen &= one.seen[f->lane] & 1;
    f->blocked = one.blocked.on[f->lane];
    if (f->blocked) f->slope = one.least[f->lane] / (1.0f - one.least[f->lane]);
}

void field_record_strata(const struct shading_point *p, struct queries *q,
                         const struct light *light, bool slopes,
                         const struct shadow_scratch *scratch, uint32_t first, uint32_t count)
{
    struct path_record_field *f = &p->record->field;
    struct path_record_light *to = &p->record->vertices[0].light;
    if (f->sample < first || f->sample >= first + count || p->record->count == 0) return;
    const struct light_packet *l = &scratch->batch[f->sample - first];
    const uint32_t i = f->lane, side = scratch->strata.l;
    f->drawn = p->lit.on[i];
    f->u[0] = strata_u(&scratch->strata, f->sample)[i];
    f->u[1] = strata_v(&scratch->strata, f->sample)[i];
    pattern_jitter(&p->plan->pattern, p->block->x_px[i], p->block->y_px[i],
                   pattern_light_dimension(f->light, side), f->jitter);
    add_stratum(p->kernels, l, slopes, f);
    if (!f->drawn) return;
    find_point(light, f);
    *to = (struct path_record_light){
        .tried = true, .light = f->light, .probability = 1.0f, .skip = l->skip[i]};
    to->traced = l->traced.on[i];
    if (to->skip != LIGHT_TRACED) return;
    f->irradiance = l->irradiance[i];
    take_ray(l, i, to);
    to->blocked = l->rays.ray.tfar[i] < l->end;
    if (to->blocked) path_record_blocker(q, &l->rays.ray, (int)i, to);
}

/* ---- rays ---- */

void field_record_bounce(const struct path_context *c, const struct block *b,
                         const struct path_vertex *from, const struct strata *s,
                         const struct lanes_mask *valid, const struct lanes3 *direction)
{
    struct path_record_field *f = &c->record->field;
    const struct pattern pattern = path_pass_pattern(c);
    const uint32_t i = f->lane;
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES];
    if (s->l == 0) {
        strata_at(s, f->sample, u, v);
        f->u[0] = u[i], f->u[1] = v[i];
    } else {
        f->u[0] = strata_u(s, f->sample)[i], f->u[1] = strata_v(s, f->sample)[i];
    }
    pattern_jitter(&pattern, b->x_px[i], b->y_px[i], PATTERN_INDIRECT, f->jitter);
    f->drawn = f->aimed = true;
    f->below = !valid->on[i];
    take(direction, i, f->direction);
    const struct lanes3 *n = &from->surface.normal;
    const float cosine =
        f->direction[0] * n->x[i] + f->direction[1] * n->y[i] + f->direction[2] * n->z[i];
    f->density = fmaxf(cosine, 0.0f) * INVERSE_PI;
}

void field_record_draw(struct path_record *record, const float u[2])
{
    record->field.drawn = true;
    memcpy(record->field.u, u, sizeof record->field.u);
}

void field_record_lobe(struct path_record *record, const struct path_vertex *v, const float wi[3],
                       const float weight[3], float whole)
{
    struct path_record_field *f = &record->field;
    const uint32_t i = f->lane;
    float d[3];
    path_from_frame(v, (int)i, wi, d);
    const struct lanes3 *facet = &v->surface.facet;
    f->aimed = true;
    f->below = !(d[0] * facet->x[i] + d[1] * facet->y[i] + d[2] * facet->z[i] > 0.0f);
    f->whole = whole;
    memcpy(f->weight, weight, sizeof f->weight);
    memcpy(f->direction, d, sizeof d);
}

void field_record_radiance(struct path_record *record, const struct path_harvest *h)
{
    const uint32_t i = record->field.lane;
    const float all[3] = {h->indirect.r[i], h->indirect.g[i], h->indirect.b[i]};
    memcpy(record->indirect, all, sizeof all);
    memcpy(record->radiance, all, sizeof all);
    record->rejected = !((all[0] < INFINITY) & (all[1] < INFINITY) & (all[2] < INFINITY));
    record->field.distance = h->distance[i];
}

void field_record_bounced(struct path_record *record, const struct indirect_sums *sums,
                          uint32_t half)
{
    struct path_record_field *f = &record->field;
    const float *weight = record->vertices[1].throughput;
    take(&sums->half[half], f->lane, record->stored);
    f->half = half != 0;
    if (record->count > 1) memcpy(f->weight, weight, sizeof f->weight);
}

void field_record_shone(struct path_record *record, const struct glossy_scratch *scratch, bool half)
{
    take(&scratch->sums.light, record->field.lane, record->stored);
    take(&scratch->lobes.reflectance, record->field.lane, record->field.reflectance);
    record->field.half = half;
}
