#pragma once
/* KHR_materials_sheen: fibres that stand on a glTF surface, under its coat.
 *
 * Their lobe is sheen * D V. D is the distribution of Estevez and Kulla (2017, "Production Friendly
 * Microfacet Sheen BRDF"), D(h) = (2 + 1/alpha) sin(h)^(1/alpha) / (2 pi); V = 1 / ((1 + Lambda(wo)
 * + Lambda(wi)) 4 |wo.z wi.z|) their fit of its masking. With E(w) the lobe's albedo, which is
 * tabulated, all that is under the fibres is scaled by the lesser of 1 - s E(wo) and 1 - s E(wi), s
 * the greatest of the sheen's colours, as the extension describes it.
 *
 * The fit sends on more light than comes in along sharp fibres at grazing directions. There we
 * divide the lobe by the greater of E(wo) and E(wi). Fibres are at least as rough as
 * SHEEN_ALPHA_MIN. Inside a volume there are none. */
#include "worker/shade/bsdf.h"

#define SHEEN_ALPHA_MIN 0.01f

/* Returns E of a direction at `cosine`, below 1, for fibres of roughness alpha. Within
 * 0.016 of an integral and 0.002 in the mean; 0.06 at cosines below 1e-3. */
float sheen_albedo(float cosine, float alpha);

static inline bool sheen_is_on(const struct bsdf *b)
{
    return b->sheen[0] + b->sheen[1] + b->sheen[2] > 0.0f;
}

/* Evaluate and sample as gltf_evaluate and gltf_sample do. Without a sheen they are the same. */
void sheen_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                    struct bsdf_value *out);
bool sheen_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                  struct bsdf_sample *out, struct bsdf_value *value);
