#pragma once
/* Do two pixels show one smooth surface, near enough for each other (filters.md section 2)? */
#include <math.h>

#include "server/reconstruct/fused.h"
#include "server/reconstruct/lanes_inline.h"
#include "server/reconstruct/shadow_lanes.h"

/* What of a pixel asks its neighbours. */
struct asker {
    float point[3], normal[3];
    float plane_least, distance_most2;
};

static inline struct asker asker_of(const struct shadow_pixels *p, size_t i)
{
    return (struct asker){{p->point[0][i], p->point[1][i], p->point[2][i]},
                          {p->normal[0][i], p->normal[1][i], p->normal[2][i]},
                          p->plane_least[i],
                          p->distance_most2[i]};
}

/* 1 if what lies at (x, y, z) with the normal (nx, ny, nz) is compatible, else 0; *squared becomes
 * the distance's square. */
LANES_INLINE int32_t compatible_point(const struct asker *p, float x, float y, float z, float nx,
                                      float ny, float nz, float *squared)
{
    const float *n = p->normal;
    const float dx = x - p->point[0], dy = y - p->point[1], dz = z - p->point[2];
    const float off = fabsf(fused(dz, n[2], fused(dy, n[1], dx * n[0])));
    const float d2 = fused(dz, dz, fused(dy, dy, dx * dx));
    const float alike = fused(n[2], nz, fused(n[1], ny, n[0] * nx));
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE;
    *squared = d2;
    return (alike >= SHADOW_COS_NORMALS) & (d2 <= p->distance_most2) &
           ((off <= p->plane_least) | (off * off <= share * d2));
}
