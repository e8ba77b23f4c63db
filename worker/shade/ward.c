#include "worker/shade/ward.h"

#include "worker/shade/beckmann_facets.h"
#include "worker/shade/lobe.h"
#include "worker/shade/roughness.h"

static float specular_share(const struct bsdf *b)
{
    return lobe_share(lobe_mean(b->model_specular), lobe_mean(b->albedo));
}

float ward_lobe(const struct bsdf *b, const float h[3], float cosine, float *pdf)
{
    float alpha[2];
    roughness_of(b, alpha);
    const float d = beckmann_facets(h, alpha), fourth = 0.25f / cosine;
    *pdf = d * h[2] * fourth;
    return d * fourth / cosine;
}

void ward_lobe_sample(const struct bsdf *b, const float wo[3], const float u[2], float wi[3])
{
    float alpha[2], h[3], sine, cosine;
    roughness_of(b, alpha);
    elementary_sincos_turn(u[1], &sine, &cosine);
    const float slope = sqrtf(-elementary_log1p(-u[0]));
    direction_normalize(alpha[0] * slope * cosine, alpha[1] * slope * sine, 1.0f, h);
    direction_reflect(wo, h, direction_dot(wo, h), wi);
}

void ward_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out)
{
    float h[3], pdf;
    const float p = specular_share(b);
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float value = ward_lobe(b, h, 0.5f * twice, &pdf);
    out->diffuse = p < 1.0f ? LAMBERT_INV_PI : 0.0f;
    for (int k = 0; k < 3; k++) out->specular[k] = b->model_specular[k] * value;
    out->pdf = p * pdf + lobe_diffuse_pdf(1.0f - p, wi[2]);
}

void ward_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 float wi[3])
{
    if (choice < specular_share(b))
        ward_lobe_sample(b, wo, u, wi);
    else
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
}
