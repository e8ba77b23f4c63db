#pragma once
/* A measured reflectance as the importer fits it: two lobes of isotropic GGX facets, D G / (4 cos
 * cos) as in ggx.h, of alpha_u with `model_specular` and of second_alpha with `second_specular`.
 * Fresnel is Schlick's, and goes on to `grazing` of each in place of 1. Beside them stands a
 * diffuse lobe as Beckmann's (lobe.h). All reflect at most 1 where albedo, model_specular and
 * second_specular add up to at most 1, and so do both of grazing. No facet is smoother than
 * BSDF_SMOOTH. */
#include "worker/shade/bsdf.h"

/* Evaluates the lobes; wo.z, wi.z >= DIRECTION_GRAZING. */
void measured_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                       struct bsdf_value *out);
/* Samples wi with the density that measured_evaluate gives; it may lie below the horizon. */
void measured_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                     float wi[3]);

/* Computes the reflectance, rgb, of facets of lobe 0 or 1. `grazing` is (1 - cosine)^5 or a mean of
 * it. */
void measured_fresnel(const struct bsdf *b, int lobe, float grazing, float out[3]);

/* Returns the probability of lobe 0 where one of both is sampled. */
float measured_first_share(const struct bsdf *b, float cosine);
