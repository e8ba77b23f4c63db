#pragma once
/* Kelemen and Szirmay-Kalos' coupled model (2001, "A microfacet based coupled specular-matte BRDF
 * model with importance sampling"): facets' light D(h) F / (4 (wo.h)^2), which is ward.h's lobe
 * times Schlick's Fresnel of `model_specular`, over a diffuse lobe that gets what the facets leave:
 * albedo (1 - E(wo)) (1 - E(wi)) / (1 - E) / pi. E(w) is the facets' directional albedo, E its
 * cosine-weighted mean, of the most reflecting colour. So a white surface loses what metal's facets
 * lose alone. */
#include "worker/shade/bsdf.h"

/* Evaluates the lobes; wo.z, wi.z >= DIRECTION_GRAZING. */
void kelemen_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                      struct bsdf_value *out);
/* Samples wi with the density that kelemen_evaluate gives; it may lie below the horizon. */
void kelemen_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                    float wi[3]);

/* Computes the facets' directional albedo, rgb, at `cosine` to the normal. */
void kelemen_reflectance(const struct bsdf *b, float cosine, float out[3]);
