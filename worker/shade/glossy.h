#pragma once
/* The glossy lobe of a surface: what its GGX facets reflect, where that can be filtered as a light
 * field of its own (docs/reconstruction.md, Glossy lobes). This one predicate decides what such a
 * field brings and what paths then leave out.
 *
 * A surface has one when it is glTF's and not clear, its facets are isotropic and its alpha is at
 * least GLOSSY_ALPHA_MIN (a roughness of 0.1). Sharper lobes show little noise, but at their
 * contacts edges that the light field of pixel centres would not smooth. */
#include "worker/shade/bsdf.h"

bool glossy_has(const struct bsdf *b);

/* Computes the directional albedo, rgb, of the lobe towards a direction at `cosine` to the normal:
 * A (f0 + (1 - f0) W), with W of coupling.h and A the share of light that facets which reflect all
 * of it send on once. It is within 1.2 % of an integral and 0.1 % in the mean; where W is least
 * exact, along sharp surfaces, within 3.5 %. glossy_has holds. */
void glossy_reflectance(const struct bsdf *b, float cosine, float out[3]);
