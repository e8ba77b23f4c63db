#pragma once
/* Ashikhmin and Shirley (2000, "An anisotropic Phong BRDF model"): a half-vector lobe with one
 * exponent along x and one along y under Schlick's Fresnel of `model_specular` (Rs), over a diffuse
 * lobe that makes room for it: 28 / (23 pi) Rd (1 - Rs) (1 - (1 - wo.z/2)^5) (1 - (1 - wi.z/2)^5).
 * (1 - Rs) has a colour: it belongs into struct bsdf's albedo, Rd (1 - Rs). */
#include "worker/shade/bsdf.h"

/* Evaluates the lobes; wo.z, wi.z >= DIRECTION_GRAZING. */
void ashikhmin_shirley_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                                struct bsdf_value *out);
/* Samples wi with the density that ashikhmin_shirley_evaluate gives; it may lie below the
 * horizon. */
void ashikhmin_shirley_sample(const struct bsdf *b, const float wo[3], float choice,
                              const float u[2], float wi[3]);
