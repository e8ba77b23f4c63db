#include "worker/shade/sheen.h"

#include "worker/shade/coupling.h"
#include "worker/shade/gltf.h"
#include "worker/shade/lobe.h"

#define NODES 16

/* The lobe's albedo by row, the root of alpha from 0.1 to 1, and column, the root of the cosine,
 * from 0 to 1, both in equal steps. Integrals of 1200 x 600 directions each; those of column 0 are
 * of a cosine of 4e-4. */
static const float albedos[NODES][NODES] = {
    {2.0137f, 2.0920f, 1.6858f, 1.1940f, 0.7697f, 0.4502f, 0.2347f, 0.1059f, 0.0398f, 0.0117f,
     0.0025f, 0.0003f, 0.0000f, 0.0000f, 0.0000f, 0.0000f},
    {1.3162f, 1.4172f, 1.2374f, 0.9782f, 0.7285f, 0.5140f, 0.3417f, 0.2118f, 0.1203f, 0.0612f,
     0.0269f, 0.0097f, 0.0026f, 0.0005f, 0.0000f, 0.0000f},
    {1.0157f, 1.1151f, 1.0136f, 0.8452f, 0.6734f, 0.5170f, 0.3819f, 0.2698f, 0.1806f, 0.1130f,
     0.0647f, 0.0330f, 0.0144f, 0.0048f, 0.0010f, 0.0000f},
    {0.8595f, 0.9562f, 0.8912f, 0.7673f, 0.6361f, 0.5127f, 0.4020f, 0.3055f, 0.2234f, 0.1559f,
     0.1023f, 0.0619f, 0.0338f, 0.0156f, 0.0051f, 0.0005f},
    {0.7729f, 0.8686f, 0.8236f, 0.7244f, 0.6165f, 0.5130f, 0.4180f, 0.3326f, 0.2572f, 0.1919f,
     0.1367f, 0.0918f, 0.0573f, 0.0317f, 0.0138f, 0.0028f},
    {0.7260f, 0.8225f, 0.7897f, 0.7052f, 0.6114f, 0.5202f, 0.4352f, 0.3575f, 0.2871f, 0.2242f,
     0.1687f, 0.1212f, 0.0825f, 0.0514f, 0.0268f, 0.0086f},
    {0.7046f, 0.8031f, 0.7785f, 0.7029f, 0.6176f, 0.5339f, 0.4554f, 0.3827f, 0.3158f, 0.2546f,
     0.1992f, 0.1500f, 0.1085f, 0.0733f, 0.0433f, 0.0184f},
    {0.7009f, 0.8025f, 0.7832f, 0.7130f, 0.6326f, 0.5534f, 0.4787f, 0.4091f, 0.3444f, 0.2843f,
     0.2288f, 0.1783f, 0.1347f, 0.0965f, 0.0623f, 0.0318f},
    {0.7100f, 0.8150f, 0.7995f, 0.7321f, 0.6542f, 0.5774f, 0.5047f, 0.4367f, 0.3730f, 0.3134f,
     0.2575f, 0.2059f, 0.1607f, 0.1201f, 0.0828f, 0.0482f},
    {0.7281f, 0.8368f, 0.8236f, 0.7573f, 0.6802f, 0.6042f, 0.5323f, 0.4648f, 0.4015f, 0.3417f,
     0.2853f, 0.2326f, 0.1860f, 0.1436f, 0.1039f, 0.0663f},
    {0.7520f, 0.8640f, 0.8520f, 0.7856f, 0.7082f, 0.6320f, 0.5600f, 0.4924f, 0.4289f, 0.3687f,
     0.3115f, 0.2578f, 0.2100f, 0.1663f, 0.1249f, 0.0852f},
    {0.7782f, 0.8928f, 0.8813f, 0.8139f, 0.7356f, 0.6586f, 0.5861f, 0.5181f, 0.4541f, 0.3933f,
     0.3354f, 0.2808f, 0.2321f, 0.1874f, 0.1449f, 0.1040f},
    {0.8027f, 0.9189f, 0.9073f, 0.8388f, 0.7594f, 0.6816f, 0.6085f, 0.5401f, 0.4757f, 0.4145f,
     0.3562f, 0.3010f, 0.2518f, 0.2065f, 0.1633f, 0.1218f},
    {0.8209f, 0.9377f, 0.9257f, 0.8565f, 0.7765f, 0.6984f, 0.6251f, 0.5567f, 0.4923f, 0.4311f,
     0.3728f, 0.3175f, 0.2682f, 0.2228f, 0.1796f, 0.1381f},
    {0.8277f, 0.9440f, 0.9321f, 0.8630f, 0.7834f, 0.7060f, 0.6335f, 0.5658f, 0.5022f, 0.4418f,
     0.3841f, 0.3294f, 0.2807f, 0.2359f, 0.1932f, 0.1522f},
    {0.8184f, 0.9329f, 0.9218f, 0.8545f, 0.7770f, 0.7016f, 0.6312f, 0.5655f, 0.5038f, 0.4452f,
     0.3891f, 0.3359f, 0.2886f, 0.2451f, 0.2036f, 0.1638f},
};

/* Something of what is beneath is seen between any fibres. */
#define ALBEDO_MAX 0.999f

/* The fibres as wo sees them. */
struct sheen {
    float alpha;
    float most;   /* the greatest colour */
    float albedo; /* E(wo), may be above 1 */
    float masked; /* Lambda(wo) */
    float passed; /* what is left for what is beneath */
    float p;      /* of choosing the lobe */
    bool reflects;
};

static float tabulated(float cosine, float alpha)
{
    float f, g;
    const float least = sqrtf(SHEEN_ALPHA_MIN);
    const float row_at = (sqrtf(alpha) - least) / (1.0f - least);
    const int column = coupling_node(sqrtf(cosine), &f);
    const int row = coupling_node(row_at > 0.0f ? row_at : 0.0f, &g);
    const float *a = &albedos[row][column], *b = &albedos[row + 1][column];
    const float low = a[0] + (a[1] - a[0]) * f, high = b[0] + (b[1] - b[0]) * f;
    return low + (high - low) * g;
}

float sheen_albedo(float cosine, float alpha)
{
    const float z = cosine < 0.0f ? 0.0f : cosine > 1.0f ? 1.0f : cosine;
    const float e = tabulated(z, alpha < 1.0f ? alpha : 1.0f);
    return e < ALBEDO_MAX ? e : ALBEDO_MAX;
}

/* Returns x^n for x in (0, 1]. */
static float power(float x, float n)
{
    return elementary_exp(n * elementary_log(x));
}

/* Returns Estevez and Kulla's fit of the logarithm of Lambda, between its rows of alpha 0 and 1. */
static float log_masking(float x, float alpha)
{
    const float k = (1.0f - alpha) * (1.0f - alpha), l = 1.0f - k;
    const float a = k * 25.3245f + l * 21.5473f, b = k * 3.32435f + l * 3.82987f;
    const float c = k * 0.16801f + l * 0.19823f, d = k * -1.27393f + l * -1.97760f;
    const float e = k * -4.85967f + l * -4.32054f;
    return a / (1.0f + b * power(x > 1e-6f ? x : 1e-6f, c)) + d * x + e;
}

static float masking(float cosine, float alpha)
{
    if (cosine < 0.5f) return elementary_exp(log_masking(cosine, alpha));
    return elementary_exp(2.0f * log_masking(0.5f, alpha) - log_masking(1.0f - cosine, alpha));
}

/* Estimates what the surface beneath sends on. */
static float beneath(const struct bsdf *b)
{
    const float dielectric = 1.0f - b->metallic;
    return LOBE_MIN + lobe_mean(b->albedo) + lobe_mean(b->through) +
           b->metallic * lobe_mean(b->base_color) +
           dielectric * (b->specular * lobe_mean(b->specular_f0) +
                         b->transmission * lobe_mean(b->base_color));
}

static void see(const struct bsdf *b, const float wo[3], struct sheen *s)
{
    const float alpha = b->sheen_alpha;
    s->alpha = alpha < SHEEN_ALPHA_MIN ? SHEEN_ALPHA_MIN : alpha > 1.0f ? 1.0f : alpha;
    s->most = b->sheen[0] > b->sheen[1] ? b->sheen[0] : b->sheen[1];
    s->most = s->most > b->sheen[2] ? s->most : b->sheen[2];
    s->reflects = !b->inside || b->thin;
    s->albedo = tabulated(wo[2] < 1.0f ? wo[2] : 1.0f, s->alpha);
    s->masked = masking(wo[2] < 1.0f ? wo[2] : 1.0f, s->alpha);
    const float sent = s->albedo < ALBEDO_MAX ? s->albedo : ALBEDO_MAX;
    s->passed = 1.0f - s->most * sent;
    s->p = s->reflects ? lobe_share(sent * lobe_mean(b->sheen), s->passed * beneath(b)) : 0.0f;
    if (s->p > 1.0f - LOBE_MIN) s->p = 1.0f - LOBE_MIN;
}

/* Returns what becomes of the lobes beneath. */
static float scale_beneath(const struct bsdf *b, const struct sheen *s, float cosine)
{
    const float in = 1.0f - s->most * sheen_albedo(fabsf(cosine), s->alpha);
    const float lesser = in < s->passed ? in : s->passed;
    if (b->thin || !(b->inside || cosine < 0.0f)) return lesser;
    /* a volume: its outer side alone has fibres */
    return !b->inside ? s->passed : cosine < 0.0f ? in : 1.0f;
}

static void add_fibres(const struct bsdf *b, const struct sheen *s, const float wo[3],
                       const float wi[3], struct bsdf_value *out)
{
    float h[3];
    if (!s->reflects || wi[2] <= 0.0f) return;
    const float z = wi[2] < 1.0f ? wi[2] : 1.0f, inverse = 1.0f / s->alpha;
    direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float sine2 = h[0] * h[0] + h[1] * h[1];
    const float d = sine2 > 0.0f ? power(sine2 < 1.0f ? sine2 : 1.0f, 0.5f * inverse) : 0.0f;
    const float hidden = 1.0f + s->masked + masking(z, s->alpha);
    const float in = tabulated(z, s->alpha), most = in > s->albedo ? in : s->albedo;
    const float value = (2.0f + inverse) * (0.5f * ELEMENTARY_INV_PI) * d /
                        (hidden * 4.0f * wo[2] * z * (most > 1.0f ? most : 1.0f));
    for (int k = 0; k < 3; k++) out->specular[k] += b->sheen[k] * value;
    out->pdf += s->p * 0.5f * ELEMENTARY_INV_PI;
}

static void combine(const struct bsdf *b, const struct sheen *s, const float wo[3],
                    const float wi[3], struct bsdf_value *inout)
{
    const float scale = scale_beneath(b, s, wi[2]);
    inout->diffuse *= scale;
    for (int k = 0; k < 3; k++) inout->specular[k] *= scale;
    inout->pdf *= 1.0f - s->p;
    add_fibres(b, s, wo, wi, inout);
}

void sheen_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                    struct bsdf_value *out)
{
    struct sheen s;
    gltf_evaluate(b, wo, wi, out);
    if (!sheen_is_on(b)) return;
    see(b, wo, &s);
    combine(b, &s, wo, wi, out);
}

/* Directions of equal density over the half sphere: no lobe is broader. */
static bool sample_fibres(const struct bsdf *b, const struct sheen *s, const float wo[3],
                          const float u[2], struct bsdf_sample *out, struct bsdf_value *value)
{
    float sine, cosine;
    const float z = u[1], r2 = (1.0f - z) * (1.0f + z), r = sqrtf(r2 > 0.0f ? r2 : 0.0f);
    elementary_sincos_turn(u[0], &sine, &cosine);
    direction_set(r * cosine, r * sine, z, out->wi);
    if (z < DIRECTION_GRAZING) return false;
    gltf_evaluate(b, wo, out->wi, value);
    combine(b, s, wo, out->wi, value);
    return true;
}

bool sheen_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                  struct bsdf_sample *out, struct bsdf_value *value)
{
    struct sheen s;
    if (!sheen_is_on(b)) return gltf_sample(b, wo, choice, u, out, value);
    see(b, wo, &s);
    if (choice < s.p) return sample_fibres(b, &s, wo, u, out, value);
    const float rest = (choice - s.p) / (1.0f - s.p);
    if (!gltf_sample(b, wo, rest, u, out, value)) return false;
    if (!out->dirac) {
        combine(b, &s, wo, out->wi, value);
        return true;
    }
    const float scale = scale_beneath(b, &s, out->wi[2]) / (1.0f - s.p);
    for (int k = 0; k < 3; k++) out->specular[k] *= scale;
    return true;
}
