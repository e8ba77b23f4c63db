#include "worker/shade/kelemen.h"

#include "worker/shade/coupling.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/lobe.h"
#include "worker/shade/ward.h"

/* What facets reflect that reflect all, by row sqrt(alpha), column sqrt(cosine), both in equal
 * steps from 0 to 1; the same of facets that reflect (1 - wo.h)^5, as its fifth root. Both are
 * means over 1500 x 1500 samples of ward.h's lobe. */
static const float white[COUPLING_NODES][COUPLING_NODES] = {
    {1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f,
     1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f},
    {0.95889f, 0.82358f, 0.96584f, 0.99370f, 0.99803f, 0.99919f, 0.99960f, 0.99978f, 0.99987f,
     0.99991f, 0.99994f, 0.99996f, 0.99997f, 0.99997f, 0.99998f, 0.99998f},
    {0.98537f, 0.84188f, 0.82344f, 0.90511f, 0.96570f, 0.98653f, 0.99356f, 0.99648f, 0.99788f,
     0.99862f, 0.99904f, 0.99930f, 0.99946f, 0.99956f, 0.99963f, 0.99968f},
    {0.99225f, 0.88900f, 0.81614f, 0.82282f, 0.87490f, 0.93035f, 0.96509f, 0.98144f, 0.98903f,
     0.99292f, 0.99511f, 0.99642f, 0.99724f, 0.99778f, 0.99815f, 0.99840f},
    {0.99517f, 0.91936f, 0.84092f, 0.81011f, 0.82118f, 0.85813f, 0.90252f, 0.93953f, 0.96346f,
     0.97685f, 0.98423f, 0.98855f, 0.99122f, 0.99296f, 0.99413f, 0.99494f},
    {0.99669f, 0.93867f, 0.86595f, 0.82092f, 0.80668f, 0.81771f, 0.84561f, 0.88094f, 0.91494f,
     0.94182f, 0.96005f, 0.97135f, 0.97829f, 0.98270f, 0.98564f, 0.98766f},
    {0.99758f, 0.95142f, 0.88628f, 0.83677f, 0.80901f, 0.80180f, 0.81143f, 0.83313f, 0.86156f,
     0.89140f, 0.91817f, 0.93918f, 0.95395f, 0.96368f, 0.97008f, 0.97441f},
    {0.99815f, 0.96019f, 0.90196f, 0.85191f, 0.81696f, 0.79798f, 0.79351f, 0.80115f, 0.81805f,
     0.84104f, 0.86682f, 0.89214f, 0.91432f, 0.93172f, 0.94414f, 0.95258f},
    {0.99852f, 0.96638f, 0.91384f, 0.86467f, 0.82580f, 0.79909f, 0.78431f, 0.78029f, 0.78552f,
     0.79826f, 0.81666f, 0.83866f, 0.86207f, 0.88461f, 0.90412f, 0.91911f},
    {0.99878f, 0.97081f, 0.92274f, 0.87477f, 0.83357f, 0.80150f, 0.77901f, 0.76566f, 0.76065f,
     0.76302f, 0.77179f, 0.78593f, 0.80432f, 0.82569f, 0.84845f, 0.87046f},
    {0.99897f, 0.97400f, 0.92928f, 0.88238f, 0.83955f, 0.80344f, 0.77490f, 0.75394f, 0.74016f,
     0.73304f, 0.73201f, 0.73657f, 0.74630f, 0.76088f, 0.78005f, 0.80372f},
    {0.99910f, 0.97629f, 0.93396f, 0.88776f, 0.84354f, 0.80407f, 0.77049f, 0.74309f, 0.72173f,
     0.70609f, 0.69582f, 0.69059f, 0.69021f, 0.69468f, 0.70430f, 0.71991f},
    {0.99919f, 0.97789f, 0.93717f, 0.89120f, 0.84555f, 0.80305f, 0.76501f, 0.73194f, 0.70386f,
     0.68056f, 0.66176f, 0.64713f, 0.63643f, 0.62947f, 0.62611f, 0.62605f},
    {0.99926f, 0.97897f, 0.93918f, 0.89298f, 0.84573f, 0.80030f, 0.75813f, 0.71987f, 0.68567f,
     0.65539f, 0.62874f, 0.60534f, 0.58473f, 0.56630f, 0.54914f, 0.53169f},
    {0.99931f, 0.97963f, 0.94019f, 0.89333f, 0.84425f, 0.79585f, 0.74971f, 0.70657f, 0.66668f,
     0.62996f, 0.59609f, 0.56459f, 0.53479f, 0.50572f, 0.47604f, 0.44432f},
    {0.99934f, 0.97995f, 0.94036f, 0.89242f, 0.84127f, 0.78982f, 0.73976f, 0.69194f, 0.64668f,
     0.60394f, 0.56340f, 0.52451f, 0.48645f, 0.44819f, 0.40876f, 0.36788f},
};
static const float grazing_roots[COUPLING_NODES][COUPLING_NODES] = {
    {0.9999f, 0.9956f, 0.9822f, 0.9600f, 0.9289f, 0.8889f, 0.8400f, 0.7822f, 0.7156f, 0.6400f,
     0.5556f, 0.4622f, 0.3600f, 0.2489f, 0.1289f, 0.0000f},
    {0.9890f, 0.9557f, 0.9748f, 0.9586f, 0.9284f, 0.8887f, 0.8399f, 0.7822f, 0.7155f, 0.6400f,
     0.5556f, 0.4622f, 0.3600f, 0.2489f, 0.1289f, 0.0000f},
    {0.9870f, 0.9520f, 0.9371f, 0.9365f, 0.9202f, 0.8854f, 0.8383f, 0.7814f, 0.7152f, 0.6399f,
     0.5557f, 0.4625f, 0.3604f, 0.2494f, 0.1296f, 0.0004f},
    {0.9763f, 0.9501f, 0.9226f, 0.9066f, 0.8926f, 0.8690f, 0.8303f, 0.7775f, 0.7135f, 0.6395f,
     0.5562f, 0.4637f, 0.3622f, 0.2517f, 0.1322f, 0.0020f},
    {0.9607f, 0.9400f, 0.9111f, 0.8865f, 0.8648f, 0.8408f, 0.8088f, 0.7647f, 0.7073f, 0.6376f,
     0.5569f, 0.4664f, 0.3665f, 0.2574f, 0.1391f, 0.0063f},
    {0.9414f, 0.9241f, 0.8962f, 0.8683f, 0.8411f, 0.8130f, 0.7809f, 0.7413f, 0.6916f, 0.6299f,
     0.5560f, 0.4705f, 0.3743f, 0.2680f, 0.1519f, 0.0149f},
    {0.9195f, 0.9044f, 0.8778f, 0.8487f, 0.8186f, 0.7873f, 0.7532f, 0.7143f, 0.6685f, 0.6139f,
     0.5487f, 0.4721f, 0.3835f, 0.2833f, 0.1710f, 0.0289f},
    {0.8961f, 0.8824f, 0.8570f, 0.8276f, 0.7961f, 0.7627f, 0.7269f, 0.6875f, 0.6433f, 0.5928f,
     0.5346f, 0.4671f, 0.3889f, 0.2986f, 0.1935f, 0.0487f},
    {0.8722f, 0.8596f, 0.8351f, 0.8058f, 0.7735f, 0.7390f, 0.7020f, 0.6621f, 0.6186f, 0.5705f,
     0.5167f, 0.4562f, 0.3873f, 0.3079f, 0.2134f, 0.0725f},
    {0.8488f, 0.8368f, 0.8131f, 0.7840f, 0.7514f, 0.7162f, 0.6786f, 0.6384f, 0.5952f, 0.5486f,
     0.4978f, 0.4421f, 0.3801f, 0.3097f, 0.2260f, 0.0961f},
    {0.8265f, 0.8150f, 0.7918f, 0.7628f, 0.7301f, 0.6946f, 0.6566f, 0.6162f, 0.5734f, 0.5278f,
     0.4790f, 0.4266f, 0.3695f, 0.3059f, 0.2312f, 0.1154f},
    {0.8058f, 0.7945f, 0.7716f, 0.7428f, 0.7101f, 0.6743f, 0.6361f, 0.5957f, 0.5530f, 0.5082f,
     0.4610f, 0.4109f, 0.3574f, 0.2987f, 0.2309f, 0.1283f},
    {0.7868f, 0.7757f, 0.7530f, 0.7242f, 0.6913f, 0.6554f, 0.6170f, 0.5765f, 0.5341f, 0.4899f,
     0.4437f, 0.3955f, 0.3445f, 0.2896f, 0.2270f, 0.1354f},
    {0.7697f, 0.7586f, 0.7359f, 0.7070f, 0.6740f, 0.6378f, 0.5992f, 0.5587f, 0.5164f, 0.4726f,
     0.4273f, 0.3805f, 0.3316f, 0.2796f, 0.2212f, 0.1383f},
    {0.7544f, 0.7433f, 0.7204f, 0.6913f, 0.6579f, 0.6215f, 0.5826f, 0.5419f, 0.4997f, 0.4563f,
     0.4118f, 0.3661f, 0.3189f, 0.2693f, 0.2143f, 0.1383f},
    {0.7409f, 0.7296f, 0.7064f, 0.6769f, 0.6431f, 0.6062f, 0.5671f, 0.5262f, 0.4840f, 0.4409f,
     0.3970f, 0.3523f, 0.3067f, 0.2591f, 0.2069f, 0.1365f},
};
/* Their cosine-weighted means by row. */
static const float white_means[COUPLING_NODES] = {
    1.00000f, 0.99987f, 0.99853f, 0.99400f, 0.98412f, 0.96703f, 0.94153f, 0.90731f,
    0.86500f, 0.81607f, 0.76239f, 0.70588f, 0.64857f, 0.59228f, 0.53840f, 0.48780f,
};
static const float grazing_means[COUPLING_NODES] = {
    0.04737f, 0.04729f, 0.04662f, 0.04484f, 0.04185f, 0.03790f, 0.03345f, 0.02896f,
    0.02475f, 0.02099f, 0.01775f, 0.01501f, 0.01273f, 0.01082f, 0.00924f, 0.00792f,
};

/* What the facets are to diffuse light. */
struct facets {
    int node;   /* the row of the tables */
    float row;  /* the fraction up to the next */
    float most; /* of the colours that they reflect */
};

static void see(const struct bsdf *b, struct facets *f)
{
    const float *c = b->model_specular, rg = c[0] > c[1] ? c[0] : c[1];
    f->node = coupling_node(sqrtf(sqrtf(b->alpha_u * b->alpha_v)), &f->row);
    f->most = rg > c[2] ? rg : c[2];
}

static float between(const float table[][COUPLING_NODES], const struct facets *f, int column,
                     float fraction)
{
    const float *a = &table[f->node][column], *b = &table[f->node + 1][column];
    const float low = a[0] + (a[1] - a[0]) * fraction, high = b[0] + (b[1] - b[0]) * fraction;
    return low + (high - low) * f->row;
}

/* Returns what facets of normal reflectance `color` reflect of the light along a direction. */
static float reflected(const struct facets *f, float color, float cosine)
{
    float fraction;
    const int column = coupling_node(sqrtf(cosine < 1.0f ? cosine : 1.0f), &fraction);
    const float root = between(grazing_roots, f, column, fraction), square = root * root;
    const float all = between(white, f, column, fraction), grazing = square * square * root;
    return color * (all - grazing) + grazing;
}

static float reflected_mean(const struct facets *f)
{
    const float *a = &white_means[f->node], *g = &grazing_means[f->node];
    const float all = a[0] + (a[1] - a[0]) * f->row, grazing = g[0] + (g[1] - g[0]) * f->row;
    return f->most * (all - grazing) + grazing;
}

/* Returns the diffuse lobe over its albedo. */
static float diffuse(const struct facets *f, float z_o, float z_i)
{
    const float out = 1.0f - reflected(f, f->most, z_o), in = 1.0f - reflected(f, f->most, z_i);
    const float all = 1.0f - reflected_mean(f);
    return out > 0.0f && in > 0.0f && all > 1e-6f ? LAMBERT_INV_PI * out * in / all : 0.0f;
}

static float specular_share(const struct bsdf *b, const struct facets *f, float cosine)
{
    const float estimate = reflected(f, lobe_mean(b->model_specular), cosine);
    const float left = 1.0f - reflected(f, f->most, cosine);
    return lobe_share(estimate > LOBE_MIN ? estimate : LOBE_MIN,
                      lobe_mean(b->albedo) * (left > 0.0f ? left : 0.0f));
}

void kelemen_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                      struct bsdf_value *out)
{
    float h[3], pdf;
    struct facets f;
    see(b, &f);
    const float p = specular_share(b, &f, wo[2]);
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float cosine = 0.5f * twice, grazing = fresnel_grazing(cosine);
    const float value = ward_lobe(b, h, cosine, &pdf);
    if (p < 1.0f) out->diffuse = diffuse(&f, wo[2], wi[2]);
    for (int k = 0; k < 3; k++)
        out->specular[k] = fresnel_schlick(b->model_specular[k], grazing) * value;
    out->pdf = p * pdf + lobe_diffuse_pdf(1.0f - p, wi[2]);
}

void kelemen_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                    float wi[3])
{
    struct facets f;
    see(b, &f);
    if (choice < specular_share(b, &f, wo[2]))
        ward_lobe_sample(b, wo, u, wi);
    else
        lambert_direction(u[0], u[1], &wi[0], &wi[1], &wi[2]);
}

void kelemen_reflectance(const struct bsdf *b, float cosine, float out[3])
{
    struct facets f;
    see(b, &f);
    for (int k = 0; k < 3; k++) out[k] = reflected(&f, b->model_specular[k], cosine);
}
