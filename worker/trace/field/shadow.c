#include "worker/trace/field/shadow.h"

#include <math.h>
#include <string.h>

#include "worker/trace/hit/block_store.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/diffuse_weight.h"
#include "worker/trace/path/path.h"
#include "worker/trace/path/path_leave.h"

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

static void trace_packet(struct queries *q, bool slopes, struct light_packet *packet)
{
    if (slopes)
        queries_closest(q, QUERY_BLOCKER, &packet->traced, &packet->rays);
    else
        queries_occluded(q, QUERY_SHADOW, &packet->traced, &packet->rays);
}

/* Asks Embree about a batch; counts rays and skips. */
static void trace_batch(struct queries *q, bool slopes, const struct shading_point *p,
                        struct light_packet *batch, uint32_t count, struct counters *counters)
{
    for (uint32_t k = 0; k < count; k++) {
        struct light_packet *packet = &batch[k];
        uint32_t traced = lanes_count(&packet->traced);
        if (traced < p->lit_count) light_count_skips(packet, &p->counted, 1, counters);
        if (traced == 0) continue;
        counters->value[COUNTER_RAYS_SHADOW] +=
            p->block->whole ? traced : lanes_count_both(&packet->traced, &p->block->kept);
        trace_packet(q, slopes, packet);
    }
}

/* Traces a batch of which no ray is spared. */
static void trace_whole_batch(struct queries *q, bool slopes, const struct shading_point *p,
                              struct light_packet *batch, uint32_t count, struct counters *counters)
{
    counters->value[COUNTER_RAYS_SHADOW] += (uint64_t)count * lanes_count(&p->counted);
    for (uint32_t k = 0; k < count; k++) trace_packet(q, slopes, &batch[k]);
}

/* Adds a batch to the sums; bytes of visibility that are whole go to their planes. */
static void add_batch(uint32_t index, const struct shading_point *p,
                      const struct light_packet *batch, uint32_t first, uint32_t count,
                      struct shadow_sums *sums, struct samples *samples)
{
    const uint32_t l = p->plan->lights[index].strata_per_axis, all = l * l;
    const bool bits = plan_light_planes(p->plan, index) >> LIGHT_PLANE_VISIBILITY & 1;
    const uint32_t end = first + count;
    p->kernels->add_strata(batch, first, count, l, sums);
    for (uint32_t i = first & ~7u; i + 8 <= end || (i < end && end == all); i += 8)
        if (bits)
            p->kernels->store_visibility(p->block, &p->surface->hit, sums,
                                         samples_light_visibility(samples, index, i >> 3));
}

/* Lanes that see nothing of the light keep 1; of surfaces that are paths' alone nothing is wanted.
 */
static void store_weight(const struct shading_point *p, const struct diffuse_sums *sums,
                         struct samples *samples, uint32_t index)
{
    _Alignas(LANES_ALIGN) float weight[LANES];
    if (!(plan_light_planes(p->plan, index) >> LIGHT_PLANE_DIFFUSE_WEIGHT & 1)) return;
    for (int i = 0; i < LANES; i++)
        weight[i] = sums->all[i] > 0.0f ? sums->weighed[i] / sums->all[i] : 1.0f;
    for (int i = 0; i < LANES; i++)
        if (p->surface->hit.on[i] && !path_leaves_to_fields(p->surface, i)) weight[i] = 0.0f;
    block_store_positive_half(p->block, weight, 1.0f, samples_light_weight(samples, index));
}

void shadow_store_unlit(uint32_t index, const struct shading_point *p, struct samples *samples)
{
    static const struct diffuse_sums none = {.all = {0.0f}};
    store_weight(p, &none, samples, index);
    if (!(plan_light_planes(p->plan, index) >> LIGHT_PLANE_VISIBILITY & 1)) return;
    uint32_t l = p->plan->lights[index].strata_per_axis, left = l * l;
    for (uint32_t byte = 0; left > 0; byte++) {
        uint32_t bits = left < 8 ? left : 8;
        uint8_t seen[LANES];
        for (int i = 0; i < LANES; i++)
            seen[i] = (uint8_t)(((1 << bits) - 1) & p->surface->hit.on[i]);
        block_store_u8(p->block, seen, samples_light_visibility(samples, index, byte));
        left -= bits;
    }
}

void shading_point_see(const struct path_kernels *kernels, const struct path_vertex *vertex,
                       struct shading_point *p)
{
    p->vertex = vertex->any_general ? vertex : NULL;
    p->path_kernels = kernels;
    if (p->vertex) layers_see(kernels, vertex, &p->layers);
}

/* Directions of a packet's rays, unit. */
static void find_directions(const struct RTCRay16 *r, struct lanes3 *out)
{
    for (int i = 0; i < LANES; i++) {
        const float x = r->dir_x[i], y = r->dir_y[i], z = r->dir_z[i];
        const float squared = x * x + y * y + z * z;
        const float share = squared > 0.0f ? 1.0f / sqrtf(squared) : 0.0f;
        out->x[i] = x * share;
        out->y[i] = y * share;
        out->z[i] = z * share;
    }
}

/* Makes of the batch's irradiance what diffuse lobes under facets make of it. */
static void weigh_batch(const struct shading_point *p, struct light_packet *batch, uint32_t count,
                        struct diffuse_sums *sums)
{
    for (uint32_t k = 0; k < count; k++) {
        struct light_packet *packet = &batch[k];
        struct lanes3 direction;
        _Alignas(LANES_ALIGN) float weight[LANES];
        find_directions(&packet->rays.ray, &direction);
        diffuse_weigh(p->path_kernels, p->vertex, &p->layers, &direction, &packet->traced, weight);
        for (int i = 0; i < LANES; i++) {
            const float e = packet->traced.on[i] ? packet->irradiance[i] : 0.0f;
            const float weighed = packet->traced.on[i] ? e * weight[i] : 0.0f;
            sums->all[i] += e;
            sums->weighed[i] += weighed;
            packet->irradiance[i] = weighed;
        }
    }
}

/* Rectangles that no lane can see need no sampling: only their skips are counted. */
static bool hidden(const struct light *light, uint32_t count, const struct shading_point *p,
                   struct light_packet *scratch, struct counters *counters)
{
    if (count == 1 || !p->kernels->light_hidden(light, p->surface, &p->lit, scratch)) return false;
    light_count_skips(scratch, &p->counted, count, counters);
    return true;
}

void shadow_trace(struct queries *q, const struct light *light, uint32_t index,
                  const struct shading_point *p, struct shadow_scratch *scratch,
                  struct samples *samples, struct counters *counters)
{
    const struct light_kernels *kernels = p->kernels;
    uint32_t l = light->plan->strata_per_axis, count = l * l;
    bool slopes = plan_light_planes(p->plan, index) >> LIGHT_PLANE_SLOPES & 1;
    struct shadow_sums *sums = &scratch->sums;
    if (hidden(light, count, p, &scratch->batch[0], counters)) {
        shadow_store_unlit(index, p, samples);
        return;
    }
    strata_init(&scratch->strata, kernels, &p->plan->pattern,
                light->is_net ? NULL : &light->lattice, p->block, pattern_light_dimension(index, l),
                l);
    memset(&scratch->diffuse, 0, sizeof scratch->diffuse);
    for (uint32_t first = 0; first < count; first += SHADOW_BATCH) {
        uint32_t n = count - first < SHADOW_BATCH ? count - first : SHADOW_BATCH;
        const bool whole = kernels->sample_strata(light, &scratch->strata, first, n, p->surface,
                                                  &p->lit, scratch->batch);
        if (p->vertex) weigh_batch(p, scratch->batch, n, &scratch->diffuse);
        if (whole)
            trace_whole_batch(q, slopes, p, scratch->batch, n, counters);
        else
            trace_batch(q, slopes, p, scratch->batch, n, counters);
        add_batch(index, p, scratch->batch, first, n, sums, samples);
        for (uint32_t k = 0; slopes && k < n; k++) kernels->add_slopes(&scratch->batch[k], sums);
    }
    block_store_f32(p->block, sums->irradiance, samples_light_irradiance(samples, index));
    store_weight(p, &scratch->diffuse, samples, index);
    if (slopes) store_slopes(p, sums, samples, index);
}
