#include "worker/shade/beckmann.h"

#include "worker/shade/beckmann_facets.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/lobe.h"
#include "worker/shade/roughness.h"

#define HALF_SQRT_PI (0.5f * ELEMENTARY_SQRT_PI)
#define INV_SQRT_PI  0.564189583547756287f
/* Slopes beyond this are rarer than a float's last digit. */
#define SLOPE_MAX 4.0f
/* Newton's steps are refused when they leave the bracket, which halves then: 24 halvings alone
 * resolve it to a float. */
#define STEPS_MAX 24

void beckmann_fresnel(const struct bsdf *b, float cosine, float out[3])
{
    if (b->eta[0] > 0.0f) {
        for (int k = 0; k < 3; k++)
            out[k] = b->model_specular[k] * fresnel_conductor(cosine, b->eta[k], b->k[k]);
        return;
    }
    const float grazing = fresnel_grazing(cosine);
    for (int k = 0; k < 3; k++) out[k] = fresnel_schlick(b->model_specular[k], grazing);
}

float beckmann_specular_share(const struct bsdf *b, float cosine)
{
    float f[3];
    beckmann_fresnel(b, cosine, f);
    const float estimate = lobe_mean(f);
    return lobe_share(estimate > LOBE_MIN ? estimate : LOBE_MIN, lobe_mean(b->albedo));
}

/* Returns Smith's Lambda: (exp(-a^2) / (a sqrt pi) - erfc a) / 2 with a = 1 / (alpha tan theta). */
static float lambda(const float w[3], const float alpha[2])
{
    const float x = alpha[0] * w[0], y = alpha[1] * w[1], slope = sqrtf(x * x + y * y);
    if (w[2] >= SLOPE_MAX * slope) return 0.0f;
    const float a = w[2] / slope; /* slope > w.z / 4 > 0 */
    const float rest = INV_SQRT_PI / a - elementary_erfcx(a);
    return rest > 0.0f ? 0.5f * elementary_exp(-a * a) * rest : 0.0f;
}

/* Returns the diffuse lobe over its albedo. */
static float diffuse(const struct bsdf *b, float z_o, float z_i)
{
    if (b->eta[0] > 0.0f) return LAMBERT_INV_PI;
    return lobe_diffuse_under_schlick(z_o, z_i);
}

void beckmann_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                       struct bsdf_value *out)
{
    float alpha[2], h[3], f[3];
    const float p = beckmann_specular_share(b, wo[2]);
    if (p < 1.0f) out->diffuse = diffuse(b, wo[2], wi[2]);
    out->pdf = lobe_diffuse_pdf(1.0f - p, wi[2]);
    if (roughness_is_smooth(b)) return;
    roughness_of(b, alpha);
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float lambda_o = lambda(wo, alpha), lambda_i = lambda(wi, alpha);
    const float common = 0.25f * beckmann_facets(h, alpha) / wo[2];
    beckmann_fresnel(b, 0.5f * twice, f);
    const float value = common / (wi[2] * (1.0f + lambda_o + lambda_i));
    for (int k = 0; k < 3; k++) out->specular[k] = f[k] * value;
    out->pdf += p * common / (1.0f + lambda_o);
}

/* Returns the slope t towards a direction of angle theta (sine, cosine) at which a share u of what
 * it sees lies below: density (cosine + t sine) exp(-t^2) from t = -cot theta on, solved by
 * Newton's method within a bracket. */
static float seen_slope(float sine, float cosine, float u)
{
    const float edge = cosine < SLOPE_MAX * sine ? cosine / sine : SLOPE_MAX;
    const float edge_exp = elementary_exp(-edge * edge), edge_erf = elementary_erf(edge);
    const float all = HALF_SQRT_PI * cosine * (1.0f + edge_erf) + 0.5f * sine * edge_exp;
    const float below = HALF_SQRT_PI * cosine * edge_erf + 0.5f * sine * edge_exp - u * all;
    float low = -edge, high = SLOPE_MAX;
    float t = elementary_erfinv(2.0f * u - 1.0f); /* the answer for theta = 0 */
    if (t < low) t = 0.5f * (low + high);
    for (int i = 0; i < STEPS_MAX; i++) {
        const float end = t * t, e = elementary_exp(-end);
        const float rest = HALF_SQRT_PI * cosine * elementary_erf(t) - 0.5f * sine * e + below;
        const float density = (cosine + t * sine) * e;
        if (rest > 0.0f)
            high = t;
        else
            low = t;
        float next = t - rest / (density > 1e-12f ? density : 1e-12f);
        if (!(next > low && next < high)) next = 0.5f * (low + high);
        const float step = fabsf(next - t);
        t = next;
        if (step < 1e-5f) break; /* the next step would be of its square */
    }
    return t;
}

/* Samples a facet that w sees. Slopes are along and across the direction, with roughness scaled to
 * 1 (Heitz and d'Eon 2014, "Importance sampling microfacet-based BSDFs using the distribution of
 * visible normals"). */
static void sample_facet(const float w[3], const float alpha[2], const float u[2], float h[3])
{
    float s[3];
    direction_normalize(alpha[0] * w[0], alpha[1] * w[1], w[2], s);
    const float sine = sqrtf(s[0] * s[0] + s[1] * s[1]);
    const float c = sine > 1e-7f ? s[0] / sine : 1.0f, d = sine > 1e-7f ? s[1] / sine : 0.0f;
    const float along = seen_slope(sine, s[2], u[0]);
    const float across = elementary_erfinv(2.0f * u[1] - 1.0f);
    direction_normalize(alpha[0] * (c * along - d * across), alpha[1] * (d * along + c * across),
                        1.0f, h);
}

void beckmann_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                     float wi[3])
{
    float alpha[2], h[3];
    if (choice >= beckmann_specular_share(b, wo[2])) {
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
        return;
    }
    roughness_of(b, alpha);
    sample_facet(wo, alpha, u, h);
    direction_reflect(wo, h, direction_dot(wo, h), wi);
}
