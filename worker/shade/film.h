#pragma once
/* KHR_materials_iridescence: a film whose two sides reflect interfering light. The formulas are
 * those of the extension's appendix, from Belcour and Barla (2017, "A Practical Extension to
 * Microfacet Theory for the Modeling of Varying Iridescence"): Airy's sum of the reflections in the
 * film. The eye's sensitivities, as sums of Gaussians, turn its spectra into colours in closed
 * form. Phases at the film's sides are 0 or pi; two reflections beside the mean are kept. Both
 * sides reflect by Schlick's fit.
 *
 * What a surface with such a film reflects is mix(schlick, film, factor). Here that takes the place
 * of Schlick's Fresnel wherever gltf.c has it. Beyond the extension, colours stay
 * in [0, 1], and a film may reflect nothing twice. */
#include "worker/shade/bsdf.h"

static inline bool film_is_on(const struct bsdf *b)
{
    return b->film > 0.0f;
}

/* Computes what facets under the film reflect, per colour, where they would reflect f0 at normal
 * incidence without it; grazing is (1 - cosine)^5 or a mean of it, the cosine that outside. */
void film_fresnel(const struct bsdf *b, const float f0[3], float grazing, float out[3]);

/* Sets b->film_mean from all else: the share of light from all sides that facets reflect, in the
 * colour in which they reflect most. It is within 0.01 of an integral. */
void film_prepare(struct bsdf *b);
