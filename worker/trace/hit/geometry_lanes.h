#pragma once
/* hit_kernels' store_geometry, relate_depths and store_sub. */
#include "proto/half.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/hit/geometry.h"
#include "worker/trace/hit/pack_lanes.h"

/* -0.99951: the half next to SUB_DEPTH_MISS, for surfaces so near that they would round to it. */
#define HALF_MISS        0xbc00u
#define HALF_BEFORE_MISS 0xbbffu

/* A number other than 0 for surfaces whose id's low bits are 0. */
#define ID_LOW_ZERO 0xffffu

static inline void store_unorms(const struct block *b, const float *v, uint16_t *plane)
{
    _Alignas(LANES_ALIGN) uint16_t packed[LANES];
    if (!plane) return;
    kernel_pack_unorms(v, packed);
    block_scatter(b, packed, plane, sizeof packed[0]);
}

static void kernel_store_geometry(const struct block *b, const struct surface *s,
                                  const struct geometry_planes *planes)
{
    _Alignas(LANES_ALIGN) uint32_t packed[LANES];
    block_scatter(b, s->distance, planes->depth, sizeof s->distance[0]);
    block_scatter(b, s->id, planes->id, sizeof s->id[0]);
    store_unorms(b, s->albedo.x, planes->albedo[0]);
    store_unorms(b, s->albedo.y, planes->albedo[1]);
    store_unorms(b, s->albedo.z, planes->albedo[2]);
    if (!planes->normal) return;
    kernel_pack_normals(&s->normal, 16, packed);
    for (int i = 0; i < LANES; i++) packed[i] &= (uint32_t)s->hit.on[i];
    block_scatter(b, packed, planes->normal, sizeof packed[0]);
}

/* Relates depths as the reader does, which takes a distance of 0 (the eye lies in a surface) for
 * none. */
static void kernel_relate_depths(const struct surface *restrict centre,
                                 const struct surface *restrict sub, float length_unit,
                                 float *restrict relative)
{
    for (int i = 0; i < LANES; i++) {
        const float reference = centre->distance[i] > 0.0f ? centre->distance[i] : length_unit;
        const float ratio = sub->distance[i] / reference;
        const float most = ratio < HALF_MAX ? ratio : HALF_MAX; /* infinite, too */
        relative[i] = sub->hit.on[i] ? most - 1.0f : SUB_DEPTH_MISS;
    }
}

static void kernel_store_sub(const struct block *restrict b, const struct surface *restrict s,
                             const uint16_t *restrict depth,
                             const struct geometry_sub_planes *restrict planes)
{
    _Alignas(LANES_ALIGN) uint32_t packed[LANES];
    _Alignas(LANES_ALIGN) uint16_t depths[LANES], normals[LANES], ids[LANES];
    kernel_pack_normals(&s->normal, 8, packed);
    for (int i = 0; i < LANES; i++) {
        const uint16_t hit = (uint16_t)s->hit.on[i], low = (uint16_t)(s->id[i] & 0xffffu);
        const uint16_t near = depth[i] == HALF_MISS ? HALF_BEFORE_MISS : depth[i];
        depths[i] = hit ? near : depth[i];
        normals[i] = (uint16_t)packed[i] & hit;
        ids[i] = hit && low == 0 ? ID_LOW_ZERO : low;
    }
    block_scatter(b, depths, planes->depth, sizeof depths[0]);
    block_scatter(b, normals, planes->normal, sizeof normals[0]);
    block_scatter(b, ids, planes->id, sizeof ids[0]);
    store_unorms(b, s->albedo.x, planes->albedo[0]);
    store_unorms(b, s->albedo.y, planes->albedo[1]);
    store_unorms(b, s->albedo.z, planes->albedo[2]);
}
