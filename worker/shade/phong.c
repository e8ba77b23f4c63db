#include "worker/shade/phong.h"

#include "worker/shade/lobe.h"

static float specular_share(const struct bsdf *b)
{
    return lobe_share(lobe_mean(b->model_specular), lobe_mean(b->albedo));
}

void phong_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                    struct bsdf_value *out)
{
    const float n = b->exponent_u, p = specular_share(b);
    const float x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] - wo[2];
    /* half the squared distance to the mirror direction is one minus the cosine to it */
    const float lobe = lobe_power(0.5f * (x * x + y * y + z * z), n) * (0.5f * ELEMENTARY_INV_PI);
    out->diffuse = p < 1.0f ? LAMBERT_INV_PI : 0.0f;
    for (int k = 0; k < 3; k++) out->specular[k] = b->model_specular[k] * (n + 2.0f) * lobe;
    out->pdf = p * (n + 1.0f) * lobe + lobe_diffuse_pdf(1.0f - p, wi[2]);
}

void phong_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                  float wi[3])
{
    if (choice >= specular_share(b)) {
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
        return;
    }
    float axis[3], s[3], t[3], sine, cosine;
    direction_mirror(wo, axis);
    direction_frame(axis, s, t);
    elementary_sincos_turn(u[1], &sine, &cosine);
    const float depth = lobe_depth(u[0], b->exponent_u);
    const float r = sqrtf(depth * (2.0f - depth)), a = 1.0f - depth;
    for (int k = 0; k < 3; k++) wi[k] = a * axis[k] + r * (cosine * s[k] + sine * t[k]);
}
