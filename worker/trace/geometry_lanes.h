#pragma once
/* lane_kernels' store_geometry. Included by lane_kernels_body.h only, after pack_lanes.h. */
#include "worker/trace/block_store.h"
#include "worker/trace/geometry.h"

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
