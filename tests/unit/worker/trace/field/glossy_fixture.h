#pragma once
/* The glossy lobe's samples, one at a time: what path_kernels' layers_gloss has sixteen of. */
#include "worker/shade/coupling.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/ggx.h"
#include "worker/shade/glossy.h"

/* A direction by a facet that wo sees, with its weight f |cos| / pdf. False: below the surface, the
 * weight is 0. glossy_has holds; wo.z > 0. */
static inline bool glossy_sample_ggx(const struct bsdf *b, const float wo[3], const float u[2],
                                     float wi[3], float weight[3])
{
    const float alpha[2] = {b->alpha_u, b->alpha_v}, coat = (1.0f - b->metallic) * b->specular;
    float h[3];
    if (wo[2] < DIRECTION_GRAZING) return false;
    ggx_sample(wo, alpha, u, h);
    const float cosine = direction_dot(wo, h), grazing = fresnel_grazing(cosine);
    direction_reflect(wo, h, cosine, wi);
    if (wi[2] < DIRECTION_GRAZING) return false;
    /* G2 / G1: of the facets that wo sees, those from which wi sees the open, too */
    const float span = ggx_span(wo, alpha);
    const float open = 4.0f * ggx_visibility(wo[2], span, wi[2], ggx_span(wi, alpha)) * wi[2] /
                       ggx_seen(wo[2], span);
    for (int k = 0; k < 3; k++)
        weight[k] = (coat * fresnel_schlick(b->specular_f0[k], grazing) +
                     b->metallic * fresnel_schlick(b->base_color[k], grazing)) *
                    open;
    return true;
}
