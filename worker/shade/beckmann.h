#pragma once
/* Cook-Torrance reflection by Beckmann facets: D F G / (4 cos cos) with Smith's masking (Walter et
 * al. 2007, "Microfacet models for refraction through rough surfaces"; the exact form with erf, not
 * its rational fit; heights of both directions correlated, Heitz 2014). F is Fresnel's of a
 * conductor where eta[0] > 0, else Schlick's of `model_specular`. Light that facets pass
 * on to other facets is lost.
 *
 * Beside it stands a diffuse lobe, albedo / pi; under Schlick's Fresnel it makes room for what that
 * adds at grazing angles: times (1 - (1 - wo.z)^5) (1 - (1 - wi.z)^5) 21 / 20, so that the two
 * reflect at most 1 where albedo + model_specular is at most 1. */
#include "worker/shade/bsdf.h"

/* Evaluates the lobes; wo.z, wi.z >= DIRECTION_GRAZING. Smooth facets are left out, as a Dirac
 * lobe. */
void beckmann_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                       struct bsdf_value *out);
/* Samples wi with the density that beckmann_evaluate gives; it may lie below the horizon. Not for
 * smooth facets. */
void beckmann_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                     float wi[3]);

/* Computes the reflectance of a facet. */
void beckmann_fresnel(const struct bsdf *b, float cosine, float out[3]);

/* Returns the probability of the specular lobe, also where it is a mirror. */
float beckmann_specular_share(const struct bsdf *b, float cosine);
