#include "worker/trace/geometry.h"

#include <math.h>

#include "proto/half.h"
#include "worker/trace/block_store.h"
#include "worker/trace/lane_kernels.h"

/* -0.99951: the half next to SUB_DEPTH_MISS, for surfaces so near that they would round to it. */
#define HALF_MISS        0xbc00u
#define HALF_BEFORE_MISS 0xbbffu
#define HALF_MOST        65504.0f

/* A number other than 0 for surfaces whose id's low bits are 0. */
#define ID_LOW_ZERO 0xffffu

static void store_unorm(const struct queries *q, const struct block *b, const float v[LANES],
                        uint16_t *plane)
{
    _Alignas(LANES_ALIGN) uint16_t packed[LANES];
    if (!plane) return;
    q->kernels->pack_unorms(v, packed);
    block_store_u16(b, packed, plane);
}

/* Into the albedo components from `first` on. */
static void store_albedo(const struct queries *q, const struct block *b, const struct surface *s,
                         struct samples *samples, enum plane_id plane, uint32_t first)
{
    store_unorm(q, b, s->albedo.x, samples_u16(samples, plane, first));
    store_unorm(q, b, s->albedo.y, samples_u16(samples, plane, first + 1));
    store_unorm(q, b, s->albedo.z, samples_u16(samples, plane, first + 2));
}

void geometry_planes_init(struct geometry_planes *p, const struct samples *samples)
{
    p->depth = samples_f32(samples, PLANE_DEPTH, 0);
    p->id = samples_u32(samples, PLANE_ID, 0);
    p->normal = samples_u32(samples, PLANE_NORMAL, 0);
    for (uint32_t k = 0; k < 3; k++) p->albedo[k] = samples_u16(samples, PLANE_ALBEDO, k);
}

void geometry_store(const struct queries *q, const struct block *b, const struct surface *s,
                    const struct geometry_planes *planes)
{
    if (lanes_count(&s->hit) > 0) /* planes begin as zeros */
        q->kernels->store_geometry(b, s, planes);
}

static void store_sub_depth(const struct plan *plan, const struct block *b,
                            const struct surface *centre, const struct surface *sub,
                            uint16_t *plane)
{
    float relative[LANES];
    uint16_t halves[LANES];
    if (!plane) return;
    for (int i = 0; i < LANES; i++) {
        /* As the reader has it, to whom a distance of 0, of an eye in a surface, is none. */
        float reference = centre->distance[i] > 0.0f ? centre->distance[i] : plan->length_unit;
        float ratio = fminf(sub->distance[i] / reference, HALF_MOST);
        relative[i] = sub->hit.on[i] ? ratio - 1.0f : SUB_DEPTH_MISS;
    }
    half_from_floats(relative, halves, LANES);
    for (int i = 0; i < LANES; i++)
        if (sub->hit.on[i] && halves[i] == HALF_MISS) halves[i] = HALF_BEFORE_MISS;
    block_store_u16(b, halves, plane);
}

void geometry_store_sub(const struct queries *q, const struct plan *plan, const struct block *b,
                        const struct surface *centre, const struct surface *sub, uint32_t k,
                        struct samples *samples)
{
    _Alignas(LANES_ALIGN) uint32_t packed[LANES];
    uint16_t normals[LANES], ids[LANES];
    q->kernels->pack_normals(&sub->normal, 8, packed);
    store_sub_depth(plan, b, centre, sub, samples_u16(samples, PLANE_SUB_DEPTH, k));
    store_albedo(q, b, sub, samples, PLANE_SUB_ALBEDO, 3 * k);
    for (int i = 0; i < LANES; i++) {
        uint16_t low = (uint16_t)(sub->id[i] & 0xffffu);
        normals[i] = (uint16_t)(packed[i] & (uint32_t)sub->hit.on[i]);
        ids[i] = sub->hit.on[i] && low == 0 ? ID_LOW_ZERO : low;
    }
    block_store_u16(b, normals, samples_u16(samples, PLANE_SUB_NORMAL, k));
    block_store_u16(b, ids, samples_u16(samples, PLANE_SUB_ID, k));
}
