#include "worker/trace/path/path_record.h"

#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/trace/path/mis.h"
#include "worker/trace/path/path_kernels.h"

#define INVERSE_PI 0.318309886183790672f

static struct path_record_vertex *current(const struct path_context *c)
{
    return &c->record->vertices[c->record->count - 1];
}

static void take(const struct lanes3 *from, float out[3])
{
    out[0] = from->x[0];
    out[1] = from->y[0];
    out[2] = from->z[0];
}

/* Begins a vertex with the ray and what it met. All else is zero. */
static void take_hit(const struct RTCRayHit16 *rays, const struct path_vertex *v,
                     struct path_record_vertex *to)
{
    const struct surface *s = &v->surface;
    const struct RTCRay16 *r = &rays->ray;
    memset(to, 0, sizeof *to);
    memcpy(to->origin, (float[]){r->org_x[0], r->org_y[0], r->org_z[0]}, sizeof to->origin);
    memcpy(to->direction, (float[]){r->dir_x[0], r->dir_y[0], r->dir_z[0]}, sizeof to->direction);
    to->hit = s->hit.on[0];
    if (!to->hit) return;
    to->distance = s->distance[0];
    take(&s->position, to->position);
    take(&s->normal, to->normal);
    take(&s->facet, to->facet);
    to->instance = s->id[0];
    to->triangle = rays->hit.primID[0];
    to->u = rays->hit.u[0];
    to->v = rays->hit.v[0];
    to->behind = s->behind.on[0];
}

void path_record_arrive(const struct path_context *c, const struct path_packet *p,
                        const struct path_vertex *v)
{
    if (c->record->count == PATH_RECORD_VERTICES) return; /* LIMIT_INDIRECT_BOUNCES forbids it */
    struct path_record_vertex *to = &c->record->vertices[c->record->count++];
    take_hit(&p->rays, v, to);
    to->pdf = p->pdf[0];
    take(&p->throughput, to->throughput);
}

void path_record_meet(const struct path_context *c, const struct path_packet *p, uint32_t light,
                      const float radiance[3], float weight)
{
    struct path_record_vertex *to = current(c);
    float throughput[3];
    if (to->met_count == PATH_RECORD_MET) return;
    struct path_record_met *met = &to->met[to->met_count++];
    *met = (struct path_record_met){.light = light, .weight = weight};
    take(&p->throughput, throughput);
    for (int k = 0; k < 3; k++) {
        met->radiance[k] = radiance[k];
        met->value[k] = radiance[k] * weight * throughput[k]; /* as path_emission.c has it */
    }
}

void path_record_surface(const struct path_context *c, const struct path_vertex *v)
{
    struct path_record_vertex *to = current(c);
    if (!to->hit) return;
    to->active = v->active.on[0];
    to->lambert = v->surface.mesh[0]->material->lambert;
    take(&v->surface.albedo, to->albedo);
    if (!to->lambert) to->bsdf = v->bsdf[0];
}

void path_record_leave(const struct path_context *c, const struct path_packet *p,
                       const struct path_vertex *v)
{
    struct path_record_vertex *to = current(c);
    if (!to->active) return;
    to->left = !v->active.on[0];
    to->is_kept = true;
    take(&p->throughput, to->kept);
}

void path_record_thin(const struct path_context *c, const struct path_packet *p,
                      const struct path_vertex *v, float stays)
{
    struct path_record_vertex *to = current(c);
    if (!to->active || to->left || !(stays < 1.0f)) return;
    to->stays = stays;
    to->thinned = !v->active.on[0];
    take(&p->throughput, to->kept);
}

/* Returns the density with which scattering would choose the direction. */
static float scattered_density(const struct path_vertex *v, const float d[3])
{
    const struct lanes3 *n = &v->surface.normal;
    const float z = d[0] * n->x[0] + d[1] * n->y[0] + d[2] * n->z[0];
    struct bsdf_value value;
    float wi[3];
    if (v->lambert.on[0]) return z > 0.0f ? z * INVERSE_PI : 0.0f;
    path_to_frame(v, 0, d, wi);
    if (v->is_far) wi[2] = -wi[2];
    const float wo[3] = {v->back.x[0], v->back.y[0], v->back.z[0]};
    bsdf_evaluate(&v->bsdf[0], wo, wi, &value);
    return value.pdf;
}

void path_record_light(const struct path_context *c, const struct path_vertex *v, uint32_t light,
                       float probability, const struct light_packet *l, const float all[3])
{
    struct path_record_vertex *vertex = current(c);
    struct path_record_light *to = &vertex->lights[vertex->light_count];
    const struct RTCRay16 *r = &l->rays.ray;
    const float way[3] = {r->dir_x[0], r->dir_y[0], r->dir_z[0]};
    const float squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    const float length = sqrtf(squared > 0.0f ? squared : 1.0f);
    if (!v->active.on[0]) return;
    vertex->last = v->last.on[0];
    if (light == UINT32_MAX) return; /* no light could reach the surface */
    vertex->light_count++;
    *to = (struct path_record_light){
        .light = light, .probability = probability, .skip = l->skip[0], .traced = l->traced.on[0]};
    if (to->skip != 0) return;
    for (int k = 0; k < 3; k++) to->direction[k] = way[k] / length;
    memcpy(to->origin, (float[]){r->org_x[0], r->org_y[0], r->org_z[0]}, sizeof to->origin);
    memcpy(to->reflected, all, sizeof to->reflected);
    to->distance = r->tfar[0] * length;
    to->density = l->density[0] * probability;
    to->scattered = scattered_density(v, to->direction);
    to->weight = mis_power_weight(to->density, to->scattered);
}

/* Traces the shadow ray again for its closest hit within to->distance, for the record alone. */
static void find_blocker(struct queries *q, const struct RTCRay16 *ray,
                         struct path_record_light *to)
{
    struct RTCRayHit16 rays;
    struct lanes_mask one;
    queries_init_rays(&rays);
    rays.ray = *ray;
    memset(&one, 0, sizeof one);
    one.on[0] = -1;
    const float x = ray->dir_x[0], y = ray->dir_y[0], z = ray->dir_z[0];
    const float length = sqrtf(x * x + y * y + z * z);
    rays.ray.tfar[0] = to->distance / length;
    queries_closest(q, QUERY_BLOCKER, &one, &rays);
    if (rays.hit.geomID[0] == RTC_INVALID_GEOMETRY_ID) return;
    const uint32_t placed = rays.hit.instID[0][0];
    to->blocker = 1 + (placed != RTC_INVALID_GEOMETRY_ID ? placed : rays.hit.geomID[0]);
    to->blocked_at = rays.ray.tfar[0] * length;
}

void path_record_shadow(const struct path_context *c, const struct path_packet *p,
                        const struct light_packet *l)
{
    struct path_record_vertex *vertex = current(c);
    struct path_record_light *to = &vertex->lights[vertex->light_count - 1];
    float throughput[3];
    if (vertex->light_count == 0 || !to->traced) return;
    to->blocked = l->rays.ray.tfar[0] < 0.0f;
    if (to->blocked) {
        find_blocker(c->queries, &l->rays.ray, to);
        return;
    }
    take(&p->throughput, throughput);
    for (int k = 0; k < 3; k++) to->value[k] = to->reflected[k] * throughput[k];
}

/* Repeats the choice of bsdf_sample, which is pure, to tell Dirac lobes. */
static void find_dirac(const struct path_packet *p, const struct path_vertex *v,
                       struct path_record_scatter *to)
{
    const uint32_t base = PATH_VERTEX + v->depth * PATH_PER_VERTEX;
    float u[2], lobe, unused;
    struct bsdf_sample sample;
    if (v->lambert.on[0] || (v->layers.any && v->layers.on.on[0])) return; /* those have none */
    path_pair(p->key[0], p->sample[0], base + PATH_DIRECTION, &u[0], &u[1]);
    path_pair(p->key[0], p->sample[0], base + PATH_CHOICE, &lobe, &unused);
    const float wo[3] = {v->back.x[0], v->back.y[0], v->back.z[0]};
    if (bsdf_sample(&v->bsdf[0], wo, lobe, u, &sample)) to->dirac = sample.dirac;
}

void path_record_scatter(const struct path_context *c, const struct path_packet *p,
                         const struct path_vertex *v, const struct path_record_scatter *scatter)
{
    struct path_record_scatter *to = &current(c)->scatter;
    if (!v->active.on[0]) return;
    *to = *scatter;
    to->tried = true;
    if (!to->on) return;
    find_dirac(p, v, to);
    if (!to->roulette) return;
    float unused;
    path_pair(p->key[0], p->sample[0], PATH_VERTEX + v->depth * PATH_PER_VERTEX + PATH_ROULETTE,
              &to->chance, &unused);
}
