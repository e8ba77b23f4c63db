#include "worker/shade/blinn_phong.h"

#include "worker/shade/lobe.h"

#define HALF_LN2 0.346573590279972655f

static float specular_share(const struct bsdf *b)
{
    return lobe_share(lobe_mean(b->model_specular), lobe_mean(b->albedo));
}

static float normalization(float n)
{
    return (n + 2.0f) * (n + 4.0f) * (0.125f * ELEMENTARY_INV_PI) /
           (n + elementary_exp(-n * HALF_LN2));
}

void blinn_phong_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                          struct bsdf_value *out)
{
    const float n = b->exponent_u, p = specular_share(b);
    float h[3];
    /* both are above the horizon: the sum has a length, twice the cosine to the half vector */
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float lobe = lobe_power(lobe_depth_of(h), n), c = normalization(n) * lobe;
    out->diffuse = p < 1.0f ? LAMBERT_INV_PI : 0.0f;
    for (int k = 0; k < 3; k++) out->specular[k] = b->model_specular[k] * c;
    /* of half vectors, over 4 wo.h */
    const float pdf = (n + 1.0f) * (0.25f * ELEMENTARY_INV_PI) * lobe / twice;
    out->pdf = p * pdf + lobe_diffuse_pdf(1.0f - p, wi[2]);
}

void blinn_phong_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                        float wi[3])
{
    if (choice >= specular_share(b)) {
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
        return;
    }
    float h[3], sine, cosine;
    elementary_sincos_turn(u[1], &sine, &cosine);
    const float depth = lobe_depth(u[0], b->exponent_u), r = sqrtf(depth * (2.0f - depth));
    direction_set(r * cosine, r * sine, 1.0f - depth, h);
    direction_reflect(wo, h, direction_dot(wo, h), wi);
}
