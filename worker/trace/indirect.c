#include "worker/trace/indirect.h"

#include <math.h>
#include <string.h>

#include "worker/shade/lambert.h"
#include "worker/trace/block_store.h"
#include "worker/trace/lane_kernels.h"

/* Beyond this the pole is near and 1/(1+z) loses its digits. */
#define POLE (-0.9999f)

/* What one sample brings back. */
struct bounce {
    struct lanes3 radiance;
    _Alignas(LANES_ALIGN) float distance[LANES]; /* 0: nothing met */
};

struct indirect_sums {
    struct lanes3 half[2]; /* of even samples, of odd ones */
    _Alignas(LANES_ALIGN) float nearest[LANES];
};

void indirect_tangents(const struct plan_camera *camera, const struct lanes3 *normal,
                       struct lanes3 *tangent, struct lanes3 *bitangent)
{
    const float *right = camera->right, *up = camera->up, *forward = camera->forward;
    for (int i = 0; i < LANES; i++) {
        float nx = normal->x[i], ny = normal->y[i], nz = normal->z[i];
        float x = nx * right[0] + ny * right[1] + nz * right[2];
        float y = nx * up[0] + ny * up[1] + nz * up[2];
        float z = -(nx * forward[0] + ny * forward[1] + nz * forward[2]);
        int pole = z < POLE;
        float a = 1.0f / (1.0f + (pole ? 0.0f : z)), b = -x * y * a;
        float t[3] = {pole ? 0.0f : 1.0f - x * x * a, pole ? -1.0f : b, pole ? 0.0f : -x};
        float s[3] = {pole ? -1.0f : b, pole ? 0.0f : 1.0f - y * y * a, pole ? 0.0f : -y};
        tangent->x[i] = t[0] * right[0] + t[1] * up[0] - t[2] * forward[0];
        tangent->y[i] = t[0] * right[1] + t[1] * up[1] - t[2] * forward[1];
        tangent->z[i] = t[0] * right[2] + t[1] * up[2] - t[2] * forward[2];
        bitangent->x[i] = s[0] * right[0] + s[1] * up[0] - s[2] * forward[0];
        bitangent->y[i] = s[0] * right[1] + s[1] * up[1] - s[2] * forward[1];
        bitangent->z[i] = s[0] * right[2] + s[1] * up[2] - s[2] * forward[2];
    }
}

/* Directions around the normals; lanes that point below the facet leave *valid. */
static void bounce_rays(const struct lanes3 *local, const struct lanes3 *tangent,
                        const struct lanes3 *bitangent, const struct surface *s,
                        struct lanes_mask *valid, struct RTCRay16 *r)
{
    for (int i = 0; i < LANES; i++) {
        float a = local->x[i], b = local->y[i], c = local->z[i];
        float x = a * tangent->x[i] + b * bitangent->x[i] + c * s->normal.x[i];
        float y = a * tangent->y[i] + b * bitangent->y[i] + c * s->normal.y[i];
        float z = a * tangent->z[i] + b * bitangent->z[i] + c * s->normal.z[i];
        float facet = x * s->facet.x[i] + y * s->facet.y[i] + z * s->facet.z[i];
        valid->on[i] &= -(facet > 0.0f);
        r->dir_x[i] = x;
        r->dir_y[i] = y;
        r->dir_z[i] = z;
        r->tfar[i] = INFINITY;
    }
}

/* The shuffled orders in which pixels visit lights. */
static void shuffle_lights(const struct light_table *lights, const struct shading_point *p,
                           struct indirect_scratch *scratch)
{
    const struct pattern *pattern = &p->plan->pattern;
    uint32_t l = p->plan->indirect_strata_per_axis;
    for (int k = 0; k < LANES; k++) {
        if (!p->lit.on[k]) continue;
        int32_t x = p->block->x_px[k], y = p->block->y_px[k];
        if (lights->count > 1)
            pattern_deck_init(&scratch->choice[k], pattern, x, y, PATTERN_INDIRECT_CHOICE, l);
        pattern_deck_init(&scratch->position[k], pattern, x, y, PATTERN_INDIRECT_LIGHT, l);
    }
}

/* Each landing point's light and the point on it, for sample i of n = l * l. Lights that several
 * lanes chose are evaluated once for all of them. */
static void sample_lights(const struct queries *q, const struct light_table *lights,
                          const struct lanes_mask *active, uint32_t i, uint32_t chosen[LANES],
                          struct indirect_scratch *scratch)
{
    _Alignas(LANES_ALIGN) float u[LANES] = {0}, v[LANES] = {0};
    uint64_t used = 0; /* LIMIT_LIGHTS bits */
    memset(&scratch->shadow.traced, 0, sizeof scratch->shadow.traced);
    for (int k = 0; k < LANES; k++) {
        float at[2];
        chosen[k] = UINT32_MAX;
        if (!active->on[k]) continue;
        chosen[k] = 0;
        if (lights->count > 1) {
            pattern_deck_draw(&scratch->choice[k], i, at);
            chosen[k] = light_table_choose(lights, at[0]);
        }
        pattern_deck_draw(&scratch->position[k], i, at);
        u[k] = at[0];
        v[k] = at[1];
        used |= UINT64_C(1) << chosen[k];
    }
    for (uint64_t rest = used; rest; rest &= rest - 1) {
        uint32_t index = (uint32_t)__builtin_ctzll(rest);
        q->kernels->sample_light(&lights->lights[index], u, v, &scratch->landing, active,
                                 &scratch->candidate);
        for (int k = 0; k < LANES; k++)
            if (chosen[k] == index) light_take_lane(&scratch->candidate, k, &scratch->shadow);
    }
}

/* Lanes whose landing surface reflects something. */
static void lit_landings(const struct surface *s, const struct block *b, struct lanes_mask *active,
                         struct counters *counters)
{
    int32_t black = 0;
    for (int i = 0; i < LANES; i++) {
        int32_t reflects = -(s->albedo.x[i] + s->albedo.y[i] + s->albedo.z[i] > 0.0f);
        black -= s->hit.on[i] & ~reflects & b->kept.on[i];
        active->on[i] = s->hit.on[i] & reflects;
    }
    counters->value[COUNTER_SKIPPED_BLACK_ALBEDO] += (uint32_t)black;
}

/* Adds what the lights send over the landing points: albedo/pi * E * color / p(light). */
static void add_direct(const struct light_table *lights, const struct surface *landing,
                       const struct light_packet *sample, const uint32_t chosen[LANES],
                       struct lanes3 *radiance)
{
    for (int i = 0; i < LANES; i++) {
        if (!sample->traced.on[i] || sample->rays.ray.tfar[i] < 0.0f) continue; /* occluded */
        const struct light *light = &lights->lights[chosen[i]];
        const float *color = light->plan->color;
        float e = sample->irradiance[i] / light->probability; /* every power is positive */
        radiance->x[i] += lambert_evaluate(landing->albedo.x[i]) * e * color[0];
        radiance->y[i] += lambert_evaluate(landing->albedo.y[i]) * e * color[1];
        radiance->z[i] += lambert_evaluate(landing->albedo.z[i]) * e * color[2];
    }
}

/* Direct light at the landing points of sample i, one shadow ray each. */
static void light_landings(struct queries *q, const struct light_table *lights,
                           const struct shading_point *p, struct indirect_scratch *scratch,
                           uint32_t i, struct lanes3 *radiance, struct counters *counters)
{
    struct lanes_mask active, counted;
    struct light_packet *shadow = &scratch->shadow;
    uint32_t chosen[LANES];
    lit_landings(&scratch->landing, p->block, &active, counters);
    sample_lights(q, lights, &active, i, chosen, scratch);
    for (int k = 0; k < LANES; k++) counted.on[k] = active.on[k] & p->block->kept.on[k];
    light_count_skips(shadow, &counted, 1, counters);
    counters->value[COUNTER_RAYS_INDIRECT_SHADOW] += lanes_count_both(&shadow->traced, &counted);
    queries_occluded(q, QUERY_BOUNCE_SHADOW, &shadow->traced, &shadow->rays);
    add_direct(lights, &scratch->landing, shadow, chosen, radiance);
}

/* Emission of geometry that no light stands for. */
static void add_emission(const struct surface *landing, struct lanes3 *radiance)
{
    for (int i = 0; i < LANES; i++) {
        int counts = !landing->light.on[i];
        radiance->x[i] += counts ? landing->emission.x[i] : 0.0f;
        radiance->y[i] += counts ? landing->emission.y[i] : 0.0f;
        radiance->z[i] += counts ? landing->emission.z[i] : 0.0f;
    }
}

/* Samples that are not finite count as black. */
static void reject(const struct block *b, struct lanes3 *radiance, struct counters *counters)
{
    int32_t rejected = 0;
    for (int i = 0; i < LANES; i++) {
        int finite =
            (radiance->x[i] < INFINITY) & (radiance->y[i] < INFINITY) & (radiance->z[i] < INFINITY);
        rejected -= -!finite & b->kept.on[i];
        radiance->x[i] = finite ? radiance->x[i] : 0.0f;
        radiance->y[i] = finite ? radiance->y[i] : 0.0f;
        radiance->z[i] = finite ? radiance->z[i] : 0.0f;
    }
    counters->value[COUNTER_REJECTED_NOT_FINITE] += (uint32_t)rejected;
}

static void trace_sample(struct queries *q, const struct light_table *lights,
                         const struct shading_point *p, const struct lanes3 *tangent,
                         const struct lanes3 *bitangent, struct indirect_scratch *scratch,
                         uint32_t i, struct bounce *out, struct counters *counters)
{
    struct lanes_mask valid = p->lit;
    struct lanes3 local;
    memset(out, 0, sizeof *out);
    lambert_sample(strata_u(&scratch->strata, i), strata_v(&scratch->strata, i), &local);
    bounce_rays(&local, tangent, bitangent, p->surface, &valid, &scratch->bounce.ray);
    uint32_t traced = lanes_count_both(&valid, &p->block->kept);
    counters->value[COUNTER_RAYS_INDIRECT] += traced;
    counters->value[COUNTER_SKIPPED_BOUNCE_BELOW_HORIZON] += lanes_count(&p->counted) - traced;
    queries_sanitise(q, &valid, &scratch->bounce.ray);
    queries_closest(q, QUERY_BOUNCE, &valid, &scratch->bounce);
    hit_resolve(q, &valid, &scratch->bounce, &scratch->landing);
    memcpy(out->distance, scratch->landing.distance, sizeof out->distance);
    add_emission(&scratch->landing, &out->radiance);
    if (lights->count > 0) light_landings(q, lights, p, scratch, i, &out->radiance, counters);
    reject(p->block, &out->radiance, counters);
}

static void add_sample(const struct bounce *b, uint32_t i, struct indirect_sums *sums)
{
    struct lanes3 *half = &sums->half[i & 1];
    for (int k = 0; k < LANES; k++) {
        half->x[k] += b->radiance.x[k];
        half->y[k] += b->radiance.y[k];
        half->z[k] += b->radiance.z[k];
        float met = b->distance[k] > 0.0f ? b->distance[k] : INFINITY;
        sums->nearest[k] = met < sums->nearest[k] ? met : sums->nearest[k];
    }
}

static void store_sample(const struct shading_point *p, const struct bounce *b, uint32_t i,
                         struct samples *samples)
{
    const float *planes[3] = {b->radiance.x, b->radiance.y, b->radiance.z};
    for (uint32_t c = 0; c < 3; c++)
        block_store_half(p->block, planes[c], p->plan->radiance_scale,
                         samples_u16(samples, PLANE_INDIRECT_STRATA, 4 * i + c));
    block_store_positive_half(p->block, b->distance, 1.0f / p->plan->length_unit,
                              samples_u16(samples, PLANE_INDIRECT_STRATA, 4 * i + 3));
}

static void store_sums(const struct shading_point *p, struct indirect_sums *sums, uint32_t count,
                       struct samples *samples)
{
    const uint32_t odd_count = count / 2;
    float even = (float)(count - odd_count), odd = (float)odd_count;
    if (count == 1) sums->half[1] = sums->half[0], odd = even;
    const float *e[3] = {sums->half[0].x, sums->half[0].y, sums->half[0].z};
    const float *o[3] = {sums->half[1].x, sums->half[1].y, sums->half[1].z};
    for (uint32_t c = 0; c < 3; c++) {
        _Alignas(LANES_ALIGN) float mean[LANES], low[LANES], high[LANES];
        for (int i = 0; i < LANES; i++) {
            low[i] = e[c][i] / even;
            high[i] = o[c][i] / odd;
            mean[i] = count == 1 ? low[i] : (e[c][i] + o[c][i]) / (even + odd);
        }
        float scale = p->plan->radiance_scale;
        block_store_half(p->block, mean, scale, samples_u16(samples, PLANE_INDIRECT_MEAN, c));
        block_store_half(p->block, low, scale, samples_u16(samples, PLANE_INDIRECT_HALVES, c));
        block_store_half(p->block, high, scale, samples_u16(samples, PLANE_INDIRECT_HALVES, c + 3));
    }
    for (int i = 0; i < LANES; i++)
        sums->nearest[i] = sums->nearest[i] < INFINITY ? sums->nearest[i] : 0.0f;
    block_store_positive_half(p->block, sums->nearest, 1.0f / p->plan->length_unit,
                              samples_u16(samples, PLANE_REFLECTOR, 0));
}

void indirect_trace(struct queries *q, const struct light_table *lights,
                    const struct shading_point *p, struct indirect_scratch *scratch,
                    struct samples *samples, struct counters *counters)
{
    uint32_t l = p->plan->indirect_strata_per_axis, count = l * l;
    bool per_stratum = p->plan->planes >> PLANE_INDIRECT_STRATA & 1;
    struct lanes3 tangent, bitangent;
    struct indirect_sums sums;
    struct RTCRay16 *r = &scratch->bounce.ray;
    memset(&sums, 0, sizeof sums);
    for (int i = 0; i < LANES; i++) sums.nearest[i] = INFINITY;
    indirect_tangents(&p->plan->camera, &p->surface->normal, &tangent, &bitangent);
    strata_init(&scratch->strata, &p->plan->pattern, p->block, PATTERN_INDIRECT, l);
    if (lights->count > 0) shuffle_lights(lights, p, scratch);
    memcpy(r->org_x, p->surface->origin.x, sizeof r->org_x);
    memcpy(r->org_y, p->surface->origin.y, sizeof r->org_y);
    memcpy(r->org_z, p->surface->origin.z, sizeof r->org_z);
    memset(r->tnear, 0, sizeof r->tnear);
    for (uint32_t i = 0; i < count; i++) {
        struct bounce bounce;
        trace_sample(q, lights, p, &tangent, &bitangent, scratch, i, &bounce, counters);
        add_sample(&bounce, i, &sums);
        if (per_stratum) store_sample(p, &bounce, i, samples);
    }
    store_sums(p, &sums, count, samples);
}
