#pragma once
/* The glossy lobe of a surface: what its facets reflect, where that can be filtered as a light
 * field of its own (docs/reconstruction.md, Glossy lobes). This one predicate decides what such a
 * field brings and what paths then leave out.
 *
 * A surface has one when it is glTF's, bare and not clear, of Blinn and Phong's, Beckmann's,
 * Ward's, Kelemen's or Ashikhmin and Shirley's model, or measured, and when its facets are nowhere
 * sharper than GGX's of GLOSSY_ALPHA_MIN (a roughness of 0.1). Sharper lobes show little noise, but
 * at their contacts edges that the light field of pixel centres would not smooth. */
#include "worker/shade/bsdf.h"

bool glossy_has(const struct bsdf *b);

/* Computes the alphas, along x and y, of GGX facets that are as sharp as the surface's: both go on
 * as exp(-1.13 x^2) near the normal, x being the angle over alpha, where Beckmann's do as
 * exp(-x^2). At most 1. Of measured surfaces they are the first lobe's. glossy_has holds. */
void glossy_alphas(const struct bsdf *b, float alpha[2]);

/* Computes the directional albedo, rgb, of the lobe towards wo: A (f0 + (1 - f0) W), with W of
 * coupling.h and A the share of light that facets which reflect all of it send on once. Of
 * isotropic glTF surfaces it is within 1.2 % of an integral and 0.1 % in the mean; where W is least
 * exact, along sharp surfaces, within 3.5 %. Of others facet_albedo.h tells. glossy_has holds. */
void glossy_reflectance(const struct bsdf *b, const float wo[3], float out[3]);

/* Samples the lobe alone by u in [0, 1)^2, with its weight f |cos| / pdf. False: the weight is 0.
 * glossy_has holds. */
bool glossy_sample(const struct bsdf *b, const float wo[3], const float u[2], float wi[3],
                   float weight[3]);
