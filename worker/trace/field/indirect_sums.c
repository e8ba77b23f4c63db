#include "worker/trace/field/indirect_sums.h"

#include <math.h>
#include <string.h>

#include "worker/trace/hit/block_store.h"

/* Half of what floats hold. */
#define MOST 1e38f

void indirect_sums_clear(struct indirect_sums *sums)
{
    memset(sums, 0, sizeof *sums);
    for (int i = 0; i < LANES; i++) sums->nearest[i] = INFINITY;
}

void indirect_sums_add(const struct field_sample *sample, float distance, uint32_t field,
                       struct indirect_sums *sums)
{
    struct lanes3 *half = &sums->half[field & 1];
    const struct lanes3 *radiance = &sample->radiance;
    for (size_t i = 0; i < LANES; i++) {
        float met = sample->distance[i];
        half->x[i] += radiance->x[i];
        half->y[i] += radiance->y[i];
        half->z[i] += radiance->z[i];
        sums->open[i] += met >= distance ? 1.0f : 0.0f;
        sums->farthest[i] = (met < INFINITY) & (met > sums->farthest[i]) ? met : sums->farthest[i];
        met = met > 0.0f ? met : INFINITY;
        sums->nearest[i] = met < sums->nearest[i] ? met : sums->nearest[i];
    }
}

static void store_radiance(const struct plan *plan, const struct block *block,
                           const uint32_t rays[LANES], const struct indirect_sums *sums,
                           struct samples *samples)
{
    const float scale = plan->radiance_scale;
    const float *e[3] = {sums->half[0].x, sums->half[0].y, sums->half[0].z};
    const float *o[3] = {sums->half[1].x, sums->half[1].y, sums->half[1].z};
    for (uint32_t c = 0; c < 3; c++) {
        _Alignas(LANES_ALIGN) float mean[LANES], low[LANES], high[LANES];
        for (int i = 0; i < LANES; i++) {
            const uint32_t count = rays[i] > 0 ? rays[i] : 1, odd_count = count / 2;
            const float even = (float)(count - odd_count), odd = (float)odd_count;
            /* sums of finite samples may be infinite */
            float e_sum = fminf(e[c][i], MOST), o_sum = fminf(o[c][i], MOST);
            low[i] = e_sum / even;
            high[i] = count > 1 ? o_sum / odd : low[i];
            mean[i] = (e_sum + o_sum) / (even + odd);
        }
        block_store_half(block, mean, scale, samples_u16(samples, PLANE_INDIRECT_MEAN, c));
        block_store_half(block, low, scale, samples_u16(samples, PLANE_INDIRECT_HALVES, c));
        block_store_half(block, high, scale, samples_u16(samples, PLANE_INDIRECT_HALVES, c + 3));
    }
}

static void store_distances(const struct plan *plan, const struct block *block,
                            const struct bounce_lanes *lanes, const uint32_t rays[LANES],
                            const struct indirect_sums *sums, struct samples *samples)
{
    _Alignas(LANES_ALIGN) float bounce_distance_min[LANES], ambient[LANES], far[LANES], open[LANES];
    const struct lanes_mask *lit = &lanes->lit, *looking = &lanes->looking;
    const float scale = 1.0f / plan->length_unit;
    for (int i = 0; i < LANES; i++) {
        const bool met = sums->nearest[i] < INFINITY;
        const float near = met ? block_distance(scale * sums->nearest[i]) : BOUNCE_DISTANCE_NONE;
        bounce_distance_min[i] = lit->on[i] ? near : 0.0f;
        ambient[i] = lit->on[i] | looking->on[i] ? near : 0.0f;
        far[i] = lit->on[i] && met ? block_distance(scale * sums->farthest[i]) : 0.0f;
        open[i] = rays[i] > 0 ? sums->open[i] / (float)rays[i] : 0.0f;
    }
    block_store_positive_half(block, bounce_distance_min, 1.0f,
                              samples_u16(samples, PLANE_BOUNCE_DISTANCE_MIN, 0));
    block_store_positive_half(block, far, 1.0f, samples_u16(samples, PLANE_BOUNCE_DISTANCE_MAX, 0));
    block_store_half(block, open, 1.0f, samples_u16(samples, PLANE_AMBIENT_VISIBILITY, 0));
    block_store_positive_half(block, ambient, 1.0f,
                              samples_u16(samples, PLANE_AMBIENT_DISTANCE_MIN, 0));
}

void indirect_sums_store(const struct plan *plan, const struct block *block,
                         const struct bounce_lanes *lanes, const uint32_t rays[LANES],
                         const struct indirect_sums *sums, struct samples *samples)
{
    store_radiance(plan, block, rays, sums, samples);
    store_distances(plan, block, lanes, rays, sums, samples);
}
