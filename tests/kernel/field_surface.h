#pragma once
/* Which neighbours show a pixel's surface (docs/reconstruction.md, Slopes and wedges), for tests
 * that add them up one by one. Rounded as kernels round it: who counts and who does not is no
 * matter of tolerance. */
#include <math.h>
#include <stdbool.h>

#include "server/reconstruct/shadow/shadow_kernels.h"

static inline float field_dot(const float a[3], const float b[3])
{
    return fmaf(a[2], b[2], fmaf(a[1], b[1], a[0] * b[0]));
}

/* Does pixel `own` take pixel `other`? *squared becomes the square of how far they are apart. */
static inline bool field_same_surface(const struct shadow_pixels *p, size_t own, size_t other,
                                      float *squared)
{
    float normal[3], beside[3], way[3];
    for (int k = 0; k < 3; k++) {
        normal[k] = p->normal[k][own];
        beside[k] = p->normal[k][other];
        way[k] = p->point[k][other] - p->point[k][own];
    }
    const float off = fabsf(field_dot(way, normal)), d2 = field_dot(way, way);
    const float share = SHADOW_PLANE_SHARE * SHADOW_PLANE_SHARE;
    *squared = d2;
    return field_dot(normal, beside) >= SHADOW_COS_NORMALS && d2 <= p->distance_most2[own] &&
           (off <= p->plane_min[own] || off * off <= share * d2);
}

/* The largest error of some numbers, over the greatest of them; infinite where one is none. */
static inline double field_error(const double *right, const float *found, size_t count)
{
    double most = 1e-6, error = 0.0;
    for (size_t i = 0; i < count; i++) {
        most = fmax(most, fabs(right[i]));
        if (!isfinite(found[i])) return INFINITY; /* fmax would pass over it */
        error = fmax(error, fabs(right[i] - (double)found[i]));
    }
    return error / most;
}
