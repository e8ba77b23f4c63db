#pragma once
/* Do two pixels show one smooth surface, near enough for each other (filters.md section 2)? */
#include <math.h>

#include "server/reconstruct/shadow_lanes.h"

/* What of a pixel asks its neighbours. */
struct asker {
    float point[3], normal[3];
    float plane_least, distance_most2;
};

static inline struct asker asker_of(const struct shadow_source *p, const struct shadow_target *t)
{
    return (struct asker){{p->point[0], p->point[1], p->point[2]},
                          {p->normal[0], p->normal[1], p->normal[2]},
                          t->plane_least,
                          t->distance_most2};
}

/* 1 if neighbour i is compatible, else 0; *squared becomes their distance's square. */
static inline int32_t compatible(const struct asker *p, const struct shadow_lanes *q, size_t i,
                                 float *squared)
{
    const float(*v)[SHADOW_PADDED] = q->number;
    const float *n = p->normal;
    const float x = v[0][i] - p->point[0], y = v[1][i] - p->point[1], z = v[2][i] - p->point[2];
    const float off = fabsf(x * n[0] + y * n[1] + z * n[2]), d2 = x * x + y * y + z * z;
    const float alike = n[0] * v[3][i] + n[1] * v[4][i] + n[2] * v[5][i];
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE;
    *squared = d2;
    return (alike >= SHADOW_COS_NORMALS) & (d2 <= p->distance_most2) &
           ((off <= p->plane_least) | (off * off <= share * d2));
}
