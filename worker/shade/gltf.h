#pragma once
/* glTF 2.0's metallic-roughness material (appendix B) with KHR_materials_specular, _ior,
 * _transmission, _diffuse_transmission, _volume, _anisotropy, _dispersion and _iridescence
 * (film.h):
 *
 *   dielectric = mix(diffuse, btdf * base_color, transmission) under facets that reflect
 *                fr = specular * (f0 + (1 - f0) (1 - V.H)^5), f0 = specular_f0, per colour
 *   metal      = facets that reflect base_color + (1 - base_color) (1 - V.H)^5
 *   material   = mix(dielectric, metal, metallic)
 *
 * Facets are GGX with Smith's masking, heights correlated; light that they pass on to other facets
 * is lost, as in the formulas of the format. Where we differ from them:
 * - The diffuse lobe gets what the facets let through of light in and out (coupling.h) in place of
 *   1 - max fr(V.H), which would reflect more light than comes in.
 * - What a volume transmits (`thin` false) reflects by Fresnel's equations in place of Schlick's
 *   fit, which knows no total reflection; `specular` and its colour scale it as they do Schlick's.
 *   Total reflection is total whatever they are.
 * - An index of 0, which by KHR_materials_ior reflects everything, or beyond GLTF_INFINITE (or one
 *   over that, from inside) does not bend either; f0 is 1 then, and Schlick's fit says it all.
 * - A dispersed volume reflects each colour by its own index, and transmits one colour, chosen by
 *   the caller (bsdf_choose_color), by that colour's.
 * - A volume of an index within GLTF_MATCHED of its surroundings' neither bends nor reflects.
 *
 * Diffuse transmission is the diffuse lobe, of an albedo of its own (`through`), mirrored at the
 * surface: what facets let through of light in and out is the same. That holds for volumes, too,
 * whatever their index.
 *
 * Refraction (Walter et al. 2007) is kept basic: radiance is not scaled by the square of the index
 * ratio. L / n^2 is what a path keeps, so that a furnace stays 1 inside glass, and emitters inside
 * a volume shine as in air. So f(wo, wi) / n(wi)^2 is reciprocal, n the index of a direction's
 * side. A thin wall transmits as it reflects, mirrored at the surface. base_color tints each
 * passage. */
#include "worker/shade/bsdf.h"

#define GLTF_MATCHED  1e-3f
#define GLTF_INFINITE 100.0f

/* Evaluates the lobes; wo.z, |wi.z| >= DIRECTION_GRAZING. */
void gltf_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out);

/* Samples wi. For a Dirac lobe it sets all of *out and leaves *value alone. Else it sets only wi
 * and dirac of *out, and *value to what gltf_evaluate gives. False: absorbed. */
bool gltf_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 struct bsdf_sample *out, struct bsdf_value *value);
