#include "worker/trace/shadow.h"

#include <string.h>

#include "worker/trace/block_store.h"
#include "worker/trace/lane_kernels.h"

static void sums_init(struct shadow_sums *s)
{
    memset(s, 0, sizeof *s);
    for (int i = 0; i < LANES; i++) s->least[i] = 1.0f;
}

/* Rays from the surfaces; their origins stay for all strata of all lights. */
static void start_rays(const struct surface *s, struct RTCRay16 *r)
{
    memcpy(r->org_x, s->origin.x, sizeof r->org_x);
    memcpy(r->org_y, s->origin.y, sizeof r->org_y);
    memcpy(r->org_z, s->origin.z, sizeof r->org_z);
    memset(r->tnear, 0, sizeof r->tnear);
}

static void end_row(struct shadow_sums *sums)
{
    for (int i = 0; i < LANES; i++) {
        sums->irradiance[i] += sums->row[i];
        sums->row[i] = 0.0f;
    }
}

static void store_visibility(const struct shading_point *p, struct shadow_sums *sums,
                             uint8_t *plane)
{
    uint8_t bytes[LANES];
    for (int i = 0; i < LANES; i++) {
        bytes[i] = (uint8_t)(sums->seen[i] & p->surface->hit.on[i]);
        sums->seen[i] = 0;
    }
    block_store_u8(p->block, bytes, plane);
}

static void store_slopes(const struct shading_point *p, const struct shadow_sums *sums,
                         struct samples *samples, uint32_t index)
{
    _Alignas(LANES_ALIGN) float least[LANES], most[LANES];
    for (int i = 0; i < LANES; i++) {
        /* blocked t ends short of 1; a blocker at the receiver itself must not read as none */
        float low = sums->least[i] > 0x1p-14f ? sums->least[i] : 0x1p-14f;
        float high = sums->most[i] > 0x1p-14f ? sums->most[i] : 0x1p-14f;
        least[i] = sums->blocked.on[i] ? low / (1.0f - low) : 0.0f;
        most[i] = sums->blocked.on[i] ? high / (1.0f - high) : 0.0f;
    }
    block_store_positive_half(p->block, least, 1.0f, samples_light_slope(samples, index, 0));
    block_store_positive_half(p->block, most, 1.0f, samples_light_slope(samples, index, 1));
}

static void trace_stratum(struct queries *q, const struct light *light, bool slopes,
                          const struct shading_point *p, const struct strata *strata, uint32_t i,
                          struct RTCRayHit16 *rays, struct shadow_sums *sums,
                          struct counters *counters)
{
    struct light_sample sample;
    struct lanes_mask traced;
    q->kernels->sample_light(light, strata_u(strata, i), strata_v(strata, i), p->surface, &sample);
    uint32_t count = q->kernels->aim(&sample, &p->lit, &rays->ray, &traced);
    if (count < p->lit_count) light_count_skips(&sample, &p->counted, counters);
    if (count > 0) {
        counters->value[COUNTER_RAYS_SHADOW] += lanes_count_both(&traced, &p->block->kept);
        if (slopes)
            queries_closest(q, QUERY_BLOCKER, &traced, rays);
        else
            queries_occluded(q, QUERY_SHADOW, &traced, rays);
    }
    q->kernels->add_stratum(&sample, &traced, rays->ray.tfar, i & 7, sums);
}

void shadow_store_unlit(uint32_t index, const struct shading_point *p, struct samples *samples)
{
    if (!(plan_light_planes(p->plan, index) >> LIGHT_PLANE_VISIBILITY & 1)) return;
    uint32_t l = p->plan->lights[index].strata_per_axis, left = l * l;
    for (uint32_t byte = 0; left > 0; byte++) {
        uint32_t bits = left < 8 ? left : 8;
        struct shadow_sums sums;
        for (int i = 0; i < LANES; i++) sums.seen[i] = (1 << bits) - 1;
        store_visibility(p, &sums, samples_light_visibility(samples, index, byte));
        left -= bits;
    }
}

void shadow_trace(struct queries *q, const struct light *light, uint32_t index,
                  const struct shading_point *p, struct strata *strata, struct RTCRayHit16 *rays,
                  struct samples *samples, struct counters *counters)
{
    uint32_t l = light->plan->strata_per_axis, count = l * l;
    bool slopes = plan_light_planes(p->plan, index) >> LIGHT_PLANE_SLOPES & 1;
    bool bits = plan_light_planes(p->plan, index) >> LIGHT_PLANE_VISIBILITY & 1;
    struct shadow_sums sums;
    sums_init(&sums);
    strata_init(strata, &p->plan->pattern, p->block, PATTERN_LIGHT + index, l);
    start_rays(p->surface, &rays->ray);
    for (uint32_t i = 0; i < count; i++) {
        trace_stratum(q, light, slopes, p, strata, i, rays, &sums, counters);
        if (i % l + 1 == l) end_row(&sums);
        if (bits && ((i & 7) == 7 || i + 1 == count))
            store_visibility(p, &sums, samples_light_visibility(samples, index, i >> 3));
    }
    for (int i = 0; i < LANES; i++) sums.irradiance[i] /= (float)count;
    block_store_f32(p->block, sums.irradiance, samples_light_irradiance(samples, index));
    if (slopes) store_slopes(p, &sums, samples, index);
    for (int i = 0; i < LANES; i++)
        counters->value[COUNTER_REJECTED_NOT_FINITE] +=
            (uint32_t) - (sums.rejected.on[i] & p->counted.on[i]);
}
