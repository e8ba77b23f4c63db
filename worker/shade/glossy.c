#include "worker/shade/glossy.h"

#include <string.h>

#include "proto/plan.h"
#include "worker/shade/beckmann.h"
#include "worker/shade/coupling.h"
#include "worker/shade/facet_albedo.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/kelemen.h"
#include "worker/shade/measured.h"

/* The root of 1.13: GGX facets as sharp as Beckmann's have an alpha larger by this. */
#define AS_GGX 1.06301458f

/* The share of light that white facets reflect once and no other facet hides, by row sqrt(alpha),
 * column sqrt(cosine), both in equal steps from 0 to 1: a mean over visible facets (512 x 512
 * directions per node). */
static const float white[COUPLING_NODES][COUPLING_NODES] = {
    {0.89207f, 0.99976f, 0.99999f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f,
     1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f, 1.00000f},
    {0.99529f, 0.89207f, 0.96454f, 0.99272f, 0.99781f, 0.99910f, 0.99954f, 0.99990f, 0.99994f,
     0.99997f, 0.99998f, 0.99999f, 0.99999f, 1.00000f, 1.00000f, 1.00000f},
    {0.99882f, 0.95254f, 0.89199f, 0.92213f, 0.96448f, 0.98460f, 0.99271f, 0.99617f, 0.99780f,
     0.99867f, 0.99912f, 0.99940f, 0.99956f, 0.99991f, 0.99997f, 1.00000f},
    {0.99947f, 0.97721f, 0.92432f, 0.89096f, 0.90482f, 0.93766f, 0.96372f, 0.97915f, 0.98756f,
     0.99214f, 0.99469f, 0.99614f, 0.99691f, 0.99719f, 0.99759f, 0.99802f},
    {0.99968f, 0.98623f, 0.94954f, 0.90909f, 0.88784f, 0.89479f, 0.91786f, 0.94215f, 0.96084f,
     0.97338f, 0.98137f, 0.98637f, 0.98949f, 0.99167f, 0.99331f, 0.99388f},
    {0.99977f, 0.98989f, 0.96319f, 0.92810f, 0.89701f, 0.88142f, 0.88488f, 0.90111f, 0.92155f,
     0.94031f, 0.95509f, 0.96587f, 0.97354f, 0.97897f, 0.98269f, 0.98540f},
    {0.99980f, 0.99114f, 0.96916f, 0.93920f, 0.90792f, 0.88293f, 0.87028f, 0.87141f, 0.88278f,
     0.89934f, 0.91673f, 0.93224f, 0.94487f, 0.95473f, 0.96215f, 0.96771f},
    {0.99980f, 0.99104f, 0.97094f, 0.94349f, 0.91325f, 0.88504f, 0.86368f, 0.85231f, 0.85149f,
     0.85922f, 0.87231f, 0.88761f, 0.90272f, 0.91631f, 0.92781f, 0.93718f},
    {0.99977f, 0.99056f, 0.96993f, 0.94274f, 0.91245f, 0.88251f, 0.85629f, 0.83666f, 0.82534f,
     0.82253f, 0.82704f, 0.83684f, 0.84971f, 0.86370f, 0.87740f, 0.88995f},
    {0.99974f, 0.98953f, 0.96713f, 0.93826f, 0.90641f, 0.87428f, 0.84437f, 0.81890f, 0.79953f,
     0.78724f, 0.78207f, 0.78329f, 0.78963f, 0.79957f, 0.81162f, 0.82453f},
    {0.99969f, 0.98801f, 0.96283f, 0.93102f, 0.89617f, 0.86083f, 0.82706f, 0.79655f, 0.77067f,
     0.75037f, 0.73614f, 0.72798f, 0.72546f, 0.72777f, 0.73396f, 0.74296f},
    {0.99962f, 0.98607f, 0.95739f, 0.92159f, 0.88258f, 0.84299f, 0.80471f, 0.76916f, 0.73738f,
     0.71012f, 0.68787f, 0.67084f, 0.65898f, 0.65200f, 0.64946f, 0.65076f},
    {0.99955f, 0.98377f, 0.95105f, 0.91042f, 0.86635f, 0.82165f, 0.77819f, 0.73728f, 0.69975f,
     0.66617f, 0.63685f, 0.61196f, 0.59150f, 0.57537f, 0.56336f, 0.55517f},
    {0.99947f, 0.98138f, 0.94397f, 0.89786f, 0.84806f, 0.79761f, 0.74848f, 0.70193f, 0.65871f,
     0.61923f, 0.58369f, 0.55212f, 0.52443f, 0.50049f, 0.48011f, 0.46306f},
    {0.99938f, 0.97878f, 0.93627f, 0.88421f, 0.82818f, 0.77157f, 0.71649f, 0.66420f, 0.61544f,
     0.57056f, 0.52965f, 0.49263f, 0.45934f, 0.42955f, 0.40299f, 0.37942f},
    {0.99928f, 0.97592f, 0.92805f, 0.86968f, 0.80713f, 0.74416f, 0.68304f, 0.62514f, 0.57119f,
     0.52151f, 0.47615f, 0.43499f, 0.39777f, 0.36422f, 0.33402f, 0.30685f},
};

static float white_albedo(float cosine, float alpha)
{
    float f, g;
    const int column = coupling_node(sqrtf(cosine), &f);
    const int row = coupling_node(sqrtf(alpha), &g);
    const float *a = &white[row][column], *b = &white[row + 1][column];
    const float low = a[0] + (a[1] - a[0]) * f, high = b[0] + (b[1] - b[0]) * f;
    return low + (high - low) * g;
}

static bool is_gltf(const struct bsdf *b)
{
    const bool facets = b->metallic > 0.0f || b->specular > 0.0f;
    return b->model == BSDF_GLTF && facets && !(b->transmission > 0.0f) && !bsdf_has_layers(b);
}

/* Returns whether the model has facets and a diffuse lobe, and no lobe besides. */
static bool is_other(const struct bsdf *b)
{
    return b->model == BSDF_BLINN_PHONG || b->model == BSDF_BECKMANN || b->model == BSDF_WARD ||
           b->model == BSDF_KELEMEN || b->model == BSDF_ASHIKHMIN_SHIRLEY ||
           b->model == BSDF_MEASURED;
}

bool glossy_has(const struct bsdf *b)
{
    float alpha[2];
    if (!is_gltf(b) && !is_other(b)) return false;
    glossy_alphas(b, alpha);
    if (b->model == BSDF_MEASURED && b->second_alpha < GLOSSY_ALPHA_MIN) return false;
    return alpha[0] >= GLOSSY_ALPHA_MIN && alpha[1] >= GLOSSY_ALPHA_MIN;
}

void glossy_alphas(const struct bsdf *b, float alpha[2])
{
    facet_widths(b, alpha);
    if (b->model == BSDF_GLTF || b->model == BSDF_MEASURED) return;
    for (int k = 0; k < 2; k++) alpha[k] = alpha[k] * AS_GGX < 1.0f ? alpha[k] * AS_GGX : 1.0f;
}

/* Computes the reflectance of a facet. `grazing` is (1 - cosine)^5 or a mean of it. */
static void reflect(const struct bsdf *b, float grazing, float out[3])
{
    const float layer = (1.0f - b->metallic) * b->specular;
    for (int k = 0; k < 3; k++)
        out[k] = layer * fresnel_schlick(b->specular_f0[k], grazing) +
                 b->metallic * fresnel_schlick(b->base_color[k], grazing);
}

/* Does the same for other models. */
static void reflect_other(const struct bsdf *b, float grazing, float out[3])
{
    const bool bare = b->model == BSDF_WARD || b->model == BSDF_BLINN_PHONG; /* of Fresnel */
    if (b->model == BSDF_BECKMANN)
        beckmann_fresnel(b, 1.0f - facet_fifth_root(grazing), out);
    else
        for (int k = 0; k < 3; k++)
            out[k] = bare ? b->model_specular[k] : fresnel_schlick(b->model_specular[k], grazing);
}

static void isotropic_reflectance(const struct bsdf *b, float cosine, float out[3])
{
    const float z = cosine < 0.0f ? 0.0f : cosine > 1.0f ? 1.0f : cosine;
    const float share = white_albedo(z, b->alpha_u);
    reflect(b, coupling_grazing(z, b->alpha_u), out);
    for (int k = 0; k < 3; k++) out[k] *= share;
}

static void measured_reflectance(const struct bsdf *b, float cosine, float out[3])
{
    const float z = cosine < 0.0f ? 0.0f : cosine > 1.0f ? 1.0f : cosine;
    out[0] = out[1] = out[2] = 0.0f;
    for (int lobe = 0; lobe < 2; lobe++) {
        const float alpha = lobe ? b->second_alpha : b->alpha_u, share = white_albedo(z, alpha);
        float f[3];
        measured_fresnel(b, lobe, coupling_grazing(z, alpha), f);
        for (int k = 0; k < 3; k++) out[k] += share * f[k];
    }
}

void glossy_reflectance(const struct bsdf *b, const float wo[3], float out[3])
{
    if (b->model == BSDF_GLTF && b->alpha_u == b->alpha_v) {
        isotropic_reflectance(b, wo[2], out);
        return;
    }
    if (b->model == BSDF_MEASURED) {
        measured_reflectance(b, wo[2], out);
        return;
    }
    if (b->model == BSDF_KELEMEN) {
        kelemen_reflectance(b, wo[2], out);
        return;
    }
    const struct facet_albedo albedo = facet_albedo_of(b, wo);
    if (b->model == BSDF_GLTF)
        reflect(b, albedo.grazing, out);
    else
        reflect_other(b, albedo.grazing, out);
    for (int k = 0; k < 3; k++) out[k] *= albedo.share;
}

/* Chooses one of a measured surface's lobes by u; returns what is left of u. */
static float choose_measured(const struct bsdf *b, const float wo[3], float u, float *choice)
{
    const float first = measured_first_share(b, wo[2]);
    *choice = u;
    if (u < first) return u / first;
    return first < 1.0f ? (u - first) / (1.0f - first) : u;
}

bool glossy_sample(const struct bsdf *b, const float wo[3], const float u[2], float wi[3],
                   float weight[3])
{
    struct bsdf bare = *b; /* beside no other lobe the facets' is always chosen */
    struct bsdf_sample s;
    float at[2] = {u[0], u[1]}, choice = 0.0f;
    memset(bare.albedo, 0, sizeof bare.albedo);
    if (b->model == BSDF_MEASURED) at[0] = choose_measured(b, wo, u[0], &choice);
    if (!bsdf_sample(&bare, wo, choice, at, &s)) return false;
    memcpy(wi, s.wi, sizeof s.wi);
    memcpy(weight, s.specular, sizeof s.specular);
    return true;
}
