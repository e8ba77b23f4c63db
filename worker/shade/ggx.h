#pragma once
/* GGX (Trowbridge-Reitz) facets, anisotropic: their distribution, the part of them that a direction
 * sees, and samples of that. alpha is the roughness along x and y, both > 0; directions have z > 0.
 *
 * Smith's masking is written as span(w) = sqrt(z^2 + (alpha_u x)^2 + (alpha_v y)^2): Lambda =
 * (span / z - 1) / 2. This stays finite at the horizon. */
#include <math.h>

#include "worker/shade/direction.h"

static inline float ggx_span(const float w[3], const float alpha[2])
{
    const float x = alpha[0] * w[0], y = alpha[1] * w[1];
    return sqrtf(x * x + y * y + w[2] * w[2]);
}

/* Returns D(h), the area of facets with normal h per area of surface and solid angle. */
static inline float ggx_facets(const float h[3], const float alpha[2])
{
    const float x = h[0] / alpha[0], y = h[1] / alpha[1];
    const float q = x * x + y * y + h[2] * h[2];
    return 1.0f / (ELEMENTARY_PI * alpha[0] * alpha[1] * q * q);
}

/* Returns G2 / (4 |wo.z wi.z|) with heights correlated (Heitz 2014, "Understanding the
 * masking-shadowing function", eq. 99): 1 / (1 + Lambda(wo) + Lambda(wi)). */
static inline float ggx_visibility(float z_o, float span_o, float z_i, float span_i)
{
    return 0.5f / (span_o * z_i + span_i * z_o);
}

/* Returns G1(w) / w.z. D(h) max(w.h, 0) times this is the density of the facets that w sees. */
static inline float ggx_seen(float z, float span)
{
    return 2.0f / (z + span);
}

/* Samples a facet that w sees, by u in [0, 1)^2: Dupuy and Benyoub (2023, "Sampling visible GGX
 * normals with spherical caps"). */
static inline void ggx_sample(const float w[3], const float alpha[2], const float u[2], float h[3])
{
    float s[3], sine, cosine;
    direction_normalize(alpha[0] * w[0], alpha[1] * w[1], w[2], s);
    elementary_sincos_turn(u[0], &sine, &cosine);
    const float z = (1.0f - u[1]) * (1.0f + s[2]) - s[2];
    const float r2 = (1.0f - z) * (1.0f + z), r = sqrtf(r2 > 0.0f ? r2 : 0.0f);
    const float hz = z + s[2];
    direction_normalize(alpha[0] * (r * cosine + s[0]), alpha[1] * (r * sine + s[1]),
                        hz > 0.0f ? hz : 0.0f, h);
}
