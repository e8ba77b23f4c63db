#include "worker/shade/bsdf.h"

#include <string.h>

#include "worker/shade/ashikhmin_shirley.h"
#include "worker/shade/beckmann.h"
#include "worker/shade/blinn_phong.h"
#include "worker/shade/coat.h"
#include "worker/shade/film.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/kelemen.h"
#include "worker/shade/lobe.h"
#include "worker/shade/measured.h"
#include "worker/shade/phong.h"
#include "worker/shade/roughness.h"
#include "worker/shade/sheen.h"
#include "worker/shade/ward.h"

/* Models that only reflect: their lobes for wi above the surface, and samples of them. NULL: there
 * are none. */
static const struct reflection {
    void (*evaluate)(const struct bsdf *b, const float wo[3], const float wi[3],
                     struct bsdf_value *out);
    void (*sample)(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                   float wi[3]);
} reflections[BSDF_MODEL_COUNT] = {
#define MODEL(number, NAME, name)
#define MODEL_OF_LOBES(number, NAME, name) [BSDF_##NAME] = {name##_evaluate, name##_sample},
#include "proto/scene/model.def"
};

static void evaluate_reflection(const struct bsdf *b, const float wo[3], const float wi[3],
                                struct bsdf_value *out)
{
    if (b->model == BSDF_LAMBERT) {
        out->diffuse = LAMBERT_INV_PI;
        out->pdf = lambert_pdf(wi[2]);
    } else if (reflections[b->model].evaluate) {
        reflections[b->model].evaluate(b, wo, wi, out);
    }
}

void bsdf_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out)
{
    *out = (struct bsdf_value){0};
    if (wo[2] < DIRECTION_GRAZING || fabsf(wi[2]) < DIRECTION_GRAZING) return;
    if (b->model == BSDF_GLTF && b->coat > 0.0f)
        coat_evaluate(b, wo, wi, out);
    else if (b->model == BSDF_GLTF)
        sheen_evaluate(b, wo, wi, out);
    else if (wi[2] > 0.0f)
        evaluate_reflection(b, wo, wi, out);
}

/* Samples a mirror of reflectance `color` that is chosen with probability p. */
static bool reflect_dirac(const float wo[3], const float color[3], float p, struct bsdf_sample *out)
{
    direction_mirror(wo, out->wi);
    for (int k = 0; k < 3; k++) out->specular[k] = color[k] / p;
    out->dirac = true;
    return color[0] > 0.0f || color[1] > 0.0f || color[2] > 0.0f;
}

static bool sample_smooth_beckmann(const struct bsdf *b, const float wo[3], float choice,
                                   const float u[2], struct bsdf_sample *out)
{
    float f[3];
    const float p = beckmann_specular_share(b, wo[2]);
    beckmann_fresnel(b, wo[2], f);
    if (choice < p) return reflect_dirac(wo, f, p, out);
    lambert_direction(u[0], u[1], &out->wi[0], &out->wi[1], &out->wi[2]);
    return true;
}

/* Models that only reflect: sets out->wi, or all of *out where the lobe is a Dirac one. */
static bool sample_reflection(const struct bsdf *b, const float wo[3], float choice,
                              const float u[2], struct bsdf_sample *out)
{
    const bool smooth = b->model == BSDF_BECKMANN && roughness_is_smooth(b);
    if (b->model == BSDF_MIRROR) return reflect_dirac(wo, b->model_specular, 1.0f, out);
    if (smooth) return sample_smooth_beckmann(b, wo, choice, u, out);
    if (b->model == BSDF_LAMBERT)
        lambert_direction(u[0], u[1], &out->wi[0], &out->wi[1], &out->wi[2]);
    else if (reflections[b->model].sample)
        reflections[b->model].sample(b, wo, choice, u, out->wi);
    else
        return false;
    return true;
}

/* Computes the weights by the formulas of bsdf_evaluate. False: all are 0. */
static bool weigh(const struct bsdf *b, const struct bsdf_value *v, struct bsdf_sample *out)
{
    if (!(v->pdf > BSDF_PDF_MIN)) return false;
    const float scale = fabsf(out->wi[2]) / v->pdf;
    bool any = false;
    for (int k = 0; k < 3; k++) {
        out->specular[k] = v->specular[k] * scale;
        any |= out->specular[k] > 0.0f || (b->albedo[k] > 0.0f && v->diffuse > 0.0f);
    }
    out->diffuse = v->diffuse * scale;
    out->pdf = v->pdf;
    out->transmitted = out->wi[2] < 0.0f;
    return any;
}

bool bsdf_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 struct bsdf_sample *out)
{
    struct bsdf_value value;
    *out = (struct bsdf_sample){0};
    if (wo[2] < DIRECTION_GRAZING) return false;
    if (b->model == BSDF_GLTF) {
        const bool found = b->coat > 0.0f ? coat_sample(b, wo, choice, u, out, &value)
                                          : sheen_sample(b, wo, choice, u, out, &value);
        if (!found) return false;
        return out->dirac || weigh(b, &value, out);
    }
    if (!sample_reflection(b, wo, choice, u, out)) return false;
    if (out->dirac) return true;
    bsdf_evaluate(b, wo, out->wi, &value);
    return weigh(b, &value, out);
}

bool bsdf_is_dirac(const struct bsdf *b)
{
    if (b->model == BSDF_MIRROR) return true;
    return b->model == BSDF_GLTF && roughness_is_smooth(b) &&
           !(b->albedo[0] + b->albedo[1] + b->albedo[2] > 0.0f) && !sheen_is_on(b) &&
           !bsdf_is_translucent(b) && (!(b->coat > 0.0f) || b->coat_alpha < BSDF_SMOOTH);
}

bool bsdf_reflects_max(const struct bsdf *b, float cosine)
{
    float far;
    if (b->model != BSDF_GLTF || (1.0f - b->metallic) * b->transmission < 0.5f) return true;
    if (b->thin) return fresnel_schlick(b->specular_f0[1], fresnel_grazing(cosine)) >= 0.5f;
    return fresnel_dielectric(cosine, b->ior, &far) >= 0.5f || far <= 0.0f;
}

void bsdf_tint(const struct bsdf *b, float out[3])
{
    float dielectric[3], metal[3];
    memcpy(dielectric, b->specular_f0, sizeof dielectric);
    memcpy(metal, b->base_color, sizeof metal);
    if (film_is_on(b)) {
        film_fresnel(b, b->specular_f0, 0.0f, dielectric);
        film_fresnel(b, b->base_color, 0.0f, metal);
    }
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0f;
        if (b->model == BSDF_GLTF)
            out[c] = b->specular * dielectric[c] * (1.0f - b->metallic) + metal[c] * b->metallic +
                     b->base_color[c] * b->transmission * (1.0f - b->metallic) +
                     b->sheen[c] * sheen_albedo(1.0f, b->sheen_alpha) + b->through[c];
        else if (b->model > BSDF_GLTF)
            out[c] = b->model_specular[c] + b->second_specular[c];
        if (out[c] > 2.0f) out[c] = 2.0f;
    }
}
