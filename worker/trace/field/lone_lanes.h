#pragma once
/* field_kernels' unpack_normals and match_subs. They answer the first questions of surface_match.h
 * in sixteen lanes, with the same bits as proto/octahedron.c and surface_match.h. */
#include "proto/octahedron.h"
#include "worker/trace/field/lone_finder.h"

static void kernel_unpack_normals(const uint32_t *restrict packed, struct lanes3 *restrict out)
{
    for (int i = 0; i < LANES; i++) {
        float n[3];
        octahedron_unpack((int16_t)(packed[i] & 0xffffu), (int16_t)(packed[i] >> 16), 32767.0f, n);
        out->x[i] = n[0];
        out->y[i] = n[1];
        out->z[i] = n[2];
    }
}

static bool kernel_match_subs(const struct surface_view *view,
                              const struct lanes_mask *restrict kept,
                              struct lone_pixels *restrict p)
{
    const struct surface_view v = *view;
    int32_t any = 0, settled = 0;
    for (int i = 0; i < LANES; i++) {
        float n[3];
        const uint32_t packed = p->sub_normal[i];
        const int32_t x = (int32_t)(packed << 24) >> 24, y = (int32_t)(packed << 16) >> 24;
        octahedron_unpack(x, y, 127.0f, n);
        const float cosine = p->facing.x[i] * n[0] + p->facing.y[i] * n[1] + p->facing.z[i] * n[2];
        const float depth = p->depth[i], distance = p->distance[i];
        const int32_t shown = -((p->sub_id[i] != 0) & (distance > 0.0f));
        const int32_t alike = -((cosine >= SURFACE_COS_FULL) & (p->sub_id[i] == p->id[i]) &
                                (depth > 0.0f) & (distance > 0.0f));
        const int32_t near = -surface_near_anyhow(&v, depth, distance), same = alike & near;
        p->alike.on[i] = alike;
        p->open.on[i] = kept->on[i] & shown & ~same;
        p->sub_depth[i] &= (uint32_t)~same; /* d / d_ref - 1: 0 */
        p->sub_normal[i] = (p->coarse[i] & (uint32_t)same) | (packed & (uint32_t)~same);
        any |= p->open.on[i];
        settled |= same;
    }
    p->settled = settled != 0;
    return any != 0;
}
