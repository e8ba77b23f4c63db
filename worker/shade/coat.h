#pragma once
/* KHR_materials_clearcoat: a clear layer of an index of 1.5 on a glTF surface and its sheen, of GGX
 * facets of its own roughness.
 *
 * Facets reflect coat * F, F by Schlick of f0 0.04. With M(w) the mean of that over the facets that
 * w sees (coupling.h), T(w) = 1 - M(w) is let through. What is under the layer is scaled
 *
 *   its diffuse lobe by T(wo) T(wi) / (1 - M), M the cosine-weighted mean of M(w), less up to 1.4 %
 *   where the surface's own facets hinder the same directions (coat.c),
 *   all other lobes by the lesser of T(wo) and T(wi),
 *
 * in place of the format's 1 - coat * F(V.N), which is not reciprocal. Both of these are, and
 * neither lets out more light than came in. A diffuse surface loses next to none of the light that
 * passes the layer. Light that leaves a volume passes the layer once, where it is outside.
 *
 * A layer with a normal of its own (coat_bent) has all its cosines and facets about that; below its
 * horizon M is as above it. What it reflects is f |wi.n| = coat * F * D * G |wi.c| / ..., c its
 * normal, so that no light is gained: in place of f, f |wi.n| / |wi.c| is reciprocal.
 *
 * The surface's emission does not pass the layer. */
#include "worker/shade/bsdf.h"

/* Evaluates and samples like gltf_evaluate and gltf_sample, for b->coat > 0. */
void coat_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out);
bool coat_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 struct bsdf_sample *out, struct bsdf_value *value);
