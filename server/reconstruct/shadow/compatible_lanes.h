#pragma once
/* Tests whether two pixels show one smooth surface, near enough to each other
 * (docs/reconstruction.md, Slopes and wedges). */
#include <math.h>

#include "server/reconstruct/shadow/shadow_lanes.h"
#include "server/reconstruct/simd/fused.h"
#include "server/reconstruct/simd/inline.h"
#include "server/reconstruct/simd/vector.h"

/* A receiving pixel's numbers for the test. */
struct compatible_receiver {
    float point[3], normal[3];
    float plane_min, distance_most2;
};

static inline struct compatible_receiver compatible_receiver_of(const struct shadow_pixels *p,
                                                                size_t i)
{
    return (struct compatible_receiver){{p->point[0][i], p->point[1][i], p->point[2][i]},
                                        {p->normal[0][i], p->normal[1][i], p->normal[2][i]},
                                        p->plane_min[i],
                                        p->distance_most2[i]};
}

/* Returns 1 if the point (x, y, z) with the normal (nx, ny, nz) is compatible, else 0. *squared
 * becomes the square of the distance. */
SIMD_INLINE int32_t compatible_point(const struct compatible_receiver *p, float x, float y, float z,
                                     float nx, float ny, float nz, float *squared)
{
    const float *n = p->normal;
    const float dx = x - p->point[0], dy = y - p->point[1], dz = z - p->point[2];
    const float off = fabsf(fused(dz, n[2], fused(dy, n[1], dx * n[0])));
    const float d2 = fused(dz, dz, fused(dy, dy, dx * dx));
    const float alike = fused(n[2], nz, fused(n[1], ny, n[0] * nx));
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE;
    *squared = d2;
    return (alike >= SHADOW_COS_NORMALS) & (d2 <= p->distance_most2) &
           ((off <= p->plane_min) | (off * off <= share * d2));
}

/* The receiving pixels of one vector. */
struct compatible_receivers {
    simd_vector point[3], normal[3];
    simd_vector plane_min, distance_most2;
};

static inline struct compatible_receivers compatible_receivers_of(const struct shadow_pixels *p,
                                                                  size_t first)
{
    struct compatible_receivers a;
    for (int k = 0; k < 3; k++) {
        a.point[k] = simd_load_vector(p->point[k] + first);
        a.normal[k] = simd_load_vector(p->normal[k] + first);
    }
    a.plane_min = simd_load_vector(p->plane_min + first);
    a.distance_most2 = simd_load_vector(p->distance_most2 + first);
    return a;
}

/* Does compatible_point for each lane. */
SIMD_INLINE simd_chosen compatible_chosen(const struct compatible_receivers *p,
                                          const simd_vector point[3], const simd_vector normal[3])
{
    simd_vector d[3];
    for (int k = 0; k < 3; k++) d[k] = point[k] - p->point[k];
    const simd_vector off = simd_positive(simd_dot(d, p->normal)), d2 = simd_dot(d, d);
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE;
    return simd_up_to(simd_same(SHADOW_COS_NORMALS), simd_dot(p->normal, normal)) &
           simd_up_to(d2, p->distance_most2) &
           (simd_up_to(off, p->plane_min) | simd_up_to(off * off, share * d2));
}
