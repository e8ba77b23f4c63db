#pragma once
/* Vectors of one lane, out of a struct lanes3 and back. */
#include <embree3/rtcore.h>

#include "worker/shade/lanes.h"
#include "worker/trace/hit/vector.h"

LANE_INLINE struct vector lane_get(const struct lanes3 *from, int i)
{
    return (struct vector){from->x[i], from->y[i], from->z[i]};
}

LANE_INLINE void lane_put(struct vector v, int i, struct lanes3 *to)
{
    to->x[i] = v.x;
    to->y[i] = v.y;
    to->z[i] = v.z;
}

LANE_INLINE struct vector lane_direction(const struct RTCRay16 *r, int i)
{
    return (struct vector){r->dir_x[i], r->dir_y[i], r->dir_z[i]};
}

LANE_INLINE float dot(struct vector a, struct vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
