#include "worker/shade/measured.h"

#include "worker/shade/fresnel.h"
#include "worker/shade/ggx.h"
#include "worker/shade/lobe.h"

static const float *color_of(const struct bsdf *b, int lobe)
{
    return lobe ? b->second_specular : b->model_specular;
}

static void alpha_of(const struct bsdf *b, int lobe, float alpha[2])
{
    const float a = lobe ? b->second_alpha : b->alpha_u;
    alpha[0] = alpha[1] = a > BSDF_SMOOTH ? a : BSDF_SMOOTH;
}

void measured_fresnel(const struct bsdf *b, int lobe, float grazing, float out[3])
{
    const float *color = color_of(b, lobe);
    for (int k = 0; k < 3; k++) out[k] = color[k] + (b->grazing[lobe] - color[k]) * grazing;
}

/* Returns what a lobe is expected to reflect along a direction; 0: there is none. */
static float estimate(const struct bsdf *b, int lobe, float cosine)
{
    float f[3];
    const bool is = lobe_mean(color_of(b, lobe)) + b->grazing[lobe] > 0.0f;
    measured_fresnel(b, lobe, fresnel_grazing(cosine), f);
    return !is ? 0.0f : lobe_mean(f) > LOBE_MIN ? lobe_mean(f) : LOBE_MIN;
}

float measured_first_share(const struct bsdf *b, float cosine)
{
    return lobe_share(estimate(b, 0, cosine), estimate(b, 1, cosine));
}

/* Returns the probability of the facets' lobes. */
static float facets_share(const struct bsdf *b, float cosine)
{
    return lobe_share(estimate(b, 0, cosine) + estimate(b, 1, cosine), lobe_mean(b->albedo));
}

void measured_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                       struct bsdf_value *out)
{
    const float p = facets_share(b, wo[2]), first = measured_first_share(b, wo[2]);
    float h[3], alpha[2], f[3];
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float grazing = fresnel_grazing(0.5f * twice);
    if (p < 1.0f) out->diffuse = lobe_diffuse_under_schlick(wo[2], wi[2]);
    out->pdf = lobe_diffuse_pdf(1.0f - p, wi[2]);
    for (int lobe = 0; lobe < 2; lobe++) {
        const float share = p * (lobe ? 1.0f - first : first);
        if (!(share > 0.0f)) continue;
        alpha_of(b, lobe, alpha);
        measured_fresnel(b, lobe, grazing, f);
        const float d = ggx_facets(h, alpha), span = ggx_span(wo, alpha);
        const float value = d * ggx_visibility(wo[2], span, wi[2], ggx_span(wi, alpha));
        for (int k = 0; k < 3; k++) out->specular[k] += f[k] * value;
        out->pdf += share * 0.25f * d * ggx_seen(wo[2], span);
    }
}

void measured_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                     float wi[3])
{
    const float p = facets_share(b, wo[2]);
    float h[3], alpha[2];
    if (choice >= p) {
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
        return;
    }
    alpha_of(b, choice >= p * measured_first_share(b, wo[2]), alpha);
    ggx_sample(wo, alpha, u, h);
    direction_reflect(wo, h, direction_dot(wo, h), wi);
}
