#include "worker/shade/ashikhmin_shirley.h"

#include "worker/shade/fresnel.h"
#include "worker/shade/lobe.h"

#define DIFFUSE_SCALE (28.0f / 23.0f * ELEMENTARY_INV_PI)

static float specular_share(const struct bsdf *b, float cosine)
{
    const float estimate = fresnel_schlick(lobe_mean(b->model_specular), fresnel_grazing(cosine));
    return lobe_share(estimate > LOBE_MIN ? estimate : LOBE_MIN, lobe_mean(b->albedo));
}

/* Returns nu cos^2 + nv sin^2 of the half vector's azimuth; at the pole, where it has none, that of
 * any. */
static float exponent(const struct bsdf *b, const float h[3])
{
    const float x2 = h[0] * h[0], y2 = h[1] * h[1], r2 = x2 + y2;
    if (r2 <= 0.0f) return b->exponent_u;
    return (b->exponent_u * x2 + b->exponent_v * y2) / r2;
}

static float diffuse_room(float cosine)
{
    return 1.0f - fresnel_grazing(0.5f * cosine);
}

void ashikhmin_shirley_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                                struct bsdf_value *out)
{
    float h[3];
    const float p = specular_share(b, wo[2]);
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float cosine = 0.5f * twice, most = wo[2] > wi[2] ? wo[2] : wi[2];
    const float scale = sqrtf((b->exponent_u + 1.0f) * (b->exponent_v + 1.0f));
    /* the density of half vectors over 4 wo.h: eq. 8 of the paper */
    const float pdf = scale * (0.125f * ELEMENTARY_INV_PI) *
                      lobe_power(lobe_depth_of(h), exponent(b, h)) / cosine;
    const float grazing = fresnel_grazing(cosine), value = pdf / most;
    for (int k = 0; k < 3; k++)
        out->specular[k] = fresnel_schlick(b->model_specular[k], grazing) * value;
    out->diffuse = p < 1.0f ? DIFFUSE_SCALE * diffuse_room(wo[2]) * diffuse_room(wi[2]) : 0.0f;
    out->pdf = p * pdf + lobe_diffuse_pdf(1.0f - p, wi[2]);
}

void ashikhmin_shirley_sample(const struct bsdf *b, const float wo[3], float choice,
                              const float u[2], float wi[3])
{
    if (choice >= specular_share(b, wo[2])) {
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
        return;
    }
    /* tan of the azimuth is sqrt((nu + 1) / (nv + 1)) times that of an even one (eq. 9) */
    float h[3], azimuth[3], sine, cosine;
    elementary_sincos_turn(u[1], &sine, &cosine);
    direction_normalize(cosine * sqrtf(b->exponent_v + 1.0f), sine * sqrtf(b->exponent_u + 1.0f),
                        0.0f, azimuth);
    const float depth = lobe_depth(u[0], exponent(b, azimuth));
    const float r = sqrtf(depth * (2.0f - depth));
    direction_set(r * azimuth[0], r * azimuth[1], 1.0f - depth, h);
    direction_reflect(wo, h, direction_dot(wo, h), wi);
}
