#pragma once
/* The roughness of facets along x and y, and its limit. Facets are one plane if both roughnesses
 * are below BSDF_SMOOTH. If only one is, it is raised to that. */
#include "worker/shade/bsdf.h"

static inline bool roughness_is_smooth(const struct bsdf *b)
{
    return b->alpha_u < BSDF_SMOOTH && b->alpha_v < BSDF_SMOOTH;
}

static inline void roughness_of(const struct bsdf *b, float alpha[2])
{
    alpha[0] = b->alpha_u > BSDF_SMOOTH ? b->alpha_u : BSDF_SMOOTH;
    alpha[1] = b->alpha_v > BSDF_SMOOTH ? b->alpha_v : BSDF_SMOOTH;
}
