#pragma once
/* Beckmann facets, anisotropic: their distribution. alpha is the roughness along x and y, both at
 * least BSDF_SMOOTH. */
#include "worker/shade/direction.h"

/* Returns D(h), the area of facets with normal h per area of surface and solid angle. */
static inline float beckmann_facets(const float h[3], const float alpha[2])
{
    const float x = h[0] / alpha[0], y = h[1] / alpha[1];
    const float z2 = h[2] * h[2] > 1e-8f ? h[2] * h[2] : 1e-8f; /* exp is 0 long before */
    return elementary_exp(-(x * x + y * y) / z2) / (ELEMENTARY_PI * alpha[0] * alpha[1] * z2 * z2);
}
