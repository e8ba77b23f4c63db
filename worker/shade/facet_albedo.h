#pragma once
/* How much light the lobe of facets reflects, for the models whose facets are spread by two
 * numbers. What facets reflect that reflect all, `share`, and the mean of (1 - wo.h)^5 over that,
 * `grazing`, give the lobe's directional albedo: share times the Fresnel reflectance at `grazing`.
 *
 * They are looked up between directions and widths, in tables that are made of the model's own
 * samples at their first use. Tables take up to 0.7 MB a model, and 10 ms for each pair
 * of widths. Any thread may call. */
#include "worker/shade/bsdf.h"
#include "worker/shade/elementary.h"

struct facet_albedo {
    float share, grazing;
};

/* Computes the widths of the model's facets along x and y as a roughness in [0, 1]: alpha, or of an
 * exponent n Beckmann's, sqrt(2 / (n + 2)) (Walter et al. 2007). */
void facet_widths(const struct bsdf *b, float alpha[2]);

/* Computes the albedo towards wo, wo.z > 0. For BSDF_GLTF, BSDF_BLINN_PHONG, BSDF_BECKMANN,
 * BSDF_ASHIKHMIN_SHIRLEY and BSDF_WARD. It is within 5 % of an integral and 0.5 % in the mean,
 * where cosines are at least 0.1 and widths 0.05; Blinn and Phong's within 8 % and 1 %. */
struct facet_albedo facet_albedo_of(const struct bsdf *b, const float wo[3]);

/* Returns the fifth root of x >= 0: 1 - cosine of `grazing`. */
static inline float facet_fifth_root(float x)
{
    return x > 1e-30f ? elementary_exp(0.2f * elementary_log(x)) : 0.0f;
}
