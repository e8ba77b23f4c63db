#pragma once
/* Unit vectors in the shading frame: z is the normal, so that z is the cosine to it. */
#include <math.h>

#include "worker/shade/elementary.h"

/* Directions this near to the surface are taken as lying in it. */
#define DIRECTION_GRAZING 1e-6f

static inline float direction_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void direction_set(float x, float y, float z, float out[3])
{
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

/* Sets out = v / |v| and returns |v|. A v of no length stays so. */
static inline float direction_normalize(float x, float y, float z, float out[3])
{
    const float length = sqrtf(x * x + y * y + z * z);
    const float inverse = 1.0f / (length > 1e-18f ? length : 1.0f);
    direction_set(x * inverse, y * inverse, z * inverse, out);
    return length;
}

/* Mirrors w at the facet of normal h; cosine = w.h. */
static inline void direction_reflect(const float w[3], const float h[3], float cosine, float out[3])
{
    const float twice = 2.0f * cosine;
    direction_set(twice * h[0] - w[0], twice * h[1] - w[1], twice * h[2] - w[2], out);
}

/* Mirrors w at the surface. */
static inline void direction_mirror(const float w[3], float out[3])
{
    direction_set(-w[0], -w[1], w[2], out);
}

/* Refracts w (cosine = w.h > 0) by a facet with index of refraction eta behind it; cosine_far > 0
 * is that of the refracted direction to -h. The result is normalised, as a small eta magnifies
 * rounding. */
static inline void direction_refract(const float w[3], const float h[3], float cosine,
                                     float cosine_far, float eta, float out[3])
{
    const float inverse = 1.0f / eta, along = cosine * inverse - cosine_far;
    direction_normalize(along * h[0] - inverse * w[0], along * h[1] - inverse * w[1],
                        along * h[2] - inverse * w[2], out);
}

/* Computes two unit vectors that make a right-handed frame with n: those of Frisvad (2012) for the
 * upper half, mirrored for the lower, so that no denominator is below 1. */
static inline void direction_frame(const float n[3], float s[3], float t[3])
{
    const float sign = elementary_copysign(1.0f, n[2]);
    const float a = -1.0f / (sign + n[2]), b = n[0] * n[1] * a;
    direction_set(1.0f + sign * n[0] * n[0] * a, sign * b, -sign * n[0], s);
    direction_set(b, sign + n[1] * n[1] * a, -n[1], t);
}
