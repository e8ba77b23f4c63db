#include "worker/shade/gltf.h"

#include "worker/shade/coupling.h"
#include "worker/shade/film.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/ggx.h"
#include "worker/shade/lobe.h"
#include "worker/shade/roughness.h"

/* What is transmitted, and how. */
enum clear_kind {
    CLEAR_NONE,
    CLEAR_THIN,   /* unbent, through rough facets mirrored */
    CLEAR_BENT,   /* refracted */
    CLEAR_MATCHED /* unbent and unhindered: a Dirac lobe whatever the roughness */
};

/* The material as wo sees it. */
struct gltf {
    float alpha[2];
    bool smooth;
    enum clear_kind clear;
    float opaque, clear_share, metal; /* shares of the surface: sum 1 */
    float index_f0;                   /* of CLEAR_BENT: ((ior - 1) / (ior + 1))^2 */
    float most_f0;                    /* the most reflecting colour's */
    float span;                       /* ggx_span of wo */
    float kept;                       /* of diffuse light on its way out: 1 - specular M(wo) */
    float p_diffuse, p_through, p_facet, p_matched; /* of choosing a lobe; sum 1, or all 0 */
};

/* What a facet does to light, per colour. */
struct facet {
    float reflect[3], transmit[3];
    float p_reflect; /* the probability of choosing reflection */
    float cosine_far;
};

static float most_of(const float c[3])
{
    const float m = c[0] > c[1] ? c[0] : c[1];
    return m > c[2] ? m : c[2];
}

static enum clear_kind clear_kind_of(const struct bsdf *b, float share)
{
    if (!(share > 0.0f)) return CLEAR_NONE;
    if (b->thin || !(b->ior > 1.0f / GLTF_INFINITE && b->ior < GLTF_INFINITE)) return CLEAR_THIN;
    return fabsf(b->ior - 1.0f) < GLTF_MATCHED ? CLEAR_MATCHED : CLEAR_BENT;
}

/* Computes what facets under a film reflect, but for `specular`, for those facets that there
 * are. */
static void filmed_of(const struct bsdf *b, const struct gltf *g, float grazing,
                      float dielectric[3], float metal[3])
{
    for (int k = 0; k < 3; k++) dielectric[k] = metal[k] = 0.0f;
    if (g->metal < 1.0f && b->specular > 0.0f) film_fresnel(b, b->specular_f0, grazing, dielectric);
    if (g->metal > 0.0f) film_fresnel(b, b->base_color, grazing, metal);
}

/* A film on a volume: `exact` is what glass without it reflects. Its outer side is outside. */
static float reflect_film(const struct bsdf *b, float cosine, float exact, float share,
                          struct facet *f)
{
    float bare[3], film[3];
    struct bsdf pure = *b;
    pure.film = 1.0f;
    film_fresnel(&pure, b->specular_f0, fresnel_grazing(b->inside ? f->cosine_far : cosine), film);
    for (int k = 0; k < 3; k++) {
        bare[k] = fresnel_schlick(b->specular_f0[k], exact);
        film[k] = b->specular * (bare[k] + (film[k] - bare[k]) * b->film);
        f->reflect[k] += share * film[k];
    }
    return most_of(film);
}

/* Does the same for a dispersed volume's colours, each by its own index. */
static void reflect_colors(const struct bsdf *b, float cosine, float share, struct facet *f)
{
    for (int k = 0; k < 3; k++) {
        float far;
        const float root = (b->iors[k] - 1.0f) / (b->iors[k] + 1.0f), f0 = root * root;
        const float exact = fresnel_dielectric(cosine, b->iors[k], &far);
        const float span = 1.0f - f0,
                    above = exact > f0 && span > 0.0f ? (exact - f0) / span : 0.0f;
        const float r = b->specular * fresnel_schlick(b->specular_f0[k], above);
        f->reflect[k] += share * (far <= 0.0f ? 1.0f : r);
    }
}

/* Fresnel's equations with f0 and weight of KHR_materials_specular in place of the index's own f0;
 * returns the greatest colour's. */
static float reflect_volume(const struct bsdf *b, const struct gltf *g, float cosine, float share,
                            struct facet *f)
{
    const float exact = fresnel_dielectric(cosine, b->ior, &f->cosine_far);
    const bool total = f->cosine_far <= 0.0f;
    const float span = 1.0f - g->index_f0;
    const float above = span > 0.0f && exact > g->index_f0 ? (exact - g->index_f0) / span : 0.0f;
    if (film_is_on(b) && !total) return reflect_film(b, cosine, above, share, f);
    if (b->dispersed) reflect_colors(b, cosine, share, f);
    for (int k = 0; !b->dispersed && k < 3; k++) {
        const float r = total ? 1.0f : b->specular * fresnel_schlick(b->specular_f0[k], above);
        f->reflect[k] += share * r;
    }
    return total ? 1.0f : b->specular * fresnel_schlick(g->most_f0, above);
}

/* Of turns that have a smaller share of the light than this fewer paths are worth the while. */
#define TURN_SHARE 0.02f

static float least_of(float least, float share)
{
    return share < TURN_SHARE ? least * (share / TURN_SHARE) : least;
}

/* Returns the probability of reflection where its share of the light is given. What clear glass
 * reflects is little and may be lamps: of few paths that the camera sends none would show them. */
static float favour(const struct bsdf *b, float share)
{
    const float least = b->turn_least * lobe_sharpness(0.5f * (b->alpha_u + b->alpha_v));
    const float low = least_of(least, share), high = 1.0f - least_of(least, 1.0f - share);
    return share < low ? low : share > high ? high : share;
}

/* Sets the facet that meets wo at `cosine`; grazing is (1 - cosine)^5 or a mean of it. */
static void facet_of(const struct bsdf *b, const struct gltf *g, float cosine, float grazing,
                     struct facet *f)
{
    const float under_schlick = g->opaque + (g->clear == CLEAR_THIN ? g->clear_share : 0.0f);
    const float layer = under_schlick * b->specular;
    float dielectric[3], metal[3], most;
    if (film_is_on(b)) {
        filmed_of(b, g, grazing, dielectric, metal);
        most = most_of(dielectric);
    } else {
        for (int k = 0; k < 3; k++) dielectric[k] = fresnel_schlick(b->specular_f0[k], grazing);
        for (int k = 0; k < 3; k++) metal[k] = fresnel_schlick(b->base_color[k], grazing);
        most = fresnel_schlick(g->most_f0, grazing);
    }
    for (int k = 0; k < 3; k++) f->reflect[k] = layer * dielectric[k] + g->metal * metal[k];
    float passes = 0.0f;
    f->cosine_far = 0.0f;
    if (g->clear == CLEAR_THIN)
        passes = g->clear_share * (1.0f - b->specular * most);
    else if (g->clear == CLEAR_BENT)
        passes = g->clear_share * (1.0f - reflect_volume(b, g, cosine, g->clear_share, f));
    for (int k = 0; k < 3; k++) f->transmit[k] = passes * b->base_color[k];
    const float r = lobe_mean(f->reflect), t = lobe_mean(f->transmit);
    f->p_reflect = t > 0.0f ? favour(b, r / (r + t)) : 1.0f;
}

/* Returns the roughness that counts in the plane of w and the normal. */
static float alpha_towards(const struct gltf *g, const float w[3])
{
    if (g->alpha[0] == g->alpha[1]) return g->alpha[0];
    const float x2 = w[0] * w[0], y2 = w[1] * w[1], r2 = x2 + y2;
    if (!(r2 > 0.0f)) return g->alpha[0];
    const float u = g->alpha[0], v = g->alpha[1];
    return sqrtf((x2 * u * u + y2 * v * v) / r2);
}

/* Returns the mean of (1 - w.h)^5 over the facets that w sees. */
static float mean_grazing(const struct gltf *g, const float w[3])
{
    return g->smooth ? fresnel_grazing(w[2]) : coupling_grazing(w[2], alpha_towards(g, w));
}

/* Returns the mean Fresnel reflectance, at its greatest colour, of facets whose mean grazing is
 * given. */
static float hindrance(const struct bsdf *b, const struct gltf *g, float grazing)
{
    float each[3];
    if (!film_is_on(b)) return b->specular * fresnel_schlick(g->most_f0, grazing);
    film_fresnel(b, b->specular_f0, grazing, each);
    return b->specular * most_of(each);
}

static bool has_facets(const struct bsdf *b, const struct gltf *g)
{
    if (g->metal > 0.0f || g->clear == CLEAR_BENT) return true;
    return g->clear == CLEAR_THIN || g->opaque * b->specular > 0.0f;
}

/* Probabilities by what each lobe is expected to give; `grazing`: the mean over facets. */
static void choose(const struct bsdf *b, struct gltf *g, const float wo[3], float grazing)
{
    struct facet f;
    facet_of(b, g, wo[2], grazing, &f);
    const float diffuse = lobe_mean(b->albedo) * g->kept;
    const float through = lobe_mean(b->through) * g->kept;
    const float matched =
        g->clear == CLEAR_MATCHED ? g->clear_share * lobe_mean(b->base_color) : 0.0f;
    float facet = lobe_mean(f.reflect) + lobe_mean(f.transmit);
    const float alpha = 0.5f * (b->alpha_u + b->alpha_v);
    const float least = lobe_least(b->seen, alpha) * (diffuse + through + matched);
    /* A smooth surface has but one facet, for which the estimate is exact. */
    const bool has = g->smooth ? b->seen && facet > 0.0f : has_facets(b, g);
    if (has && facet < least) facet = least;
    const float sum = diffuse + through + matched + facet, scale = sum > 1e-20f ? 1.0f / sum : 0.0f;
    g->p_diffuse = diffuse * scale;
    if (g->p_diffuse > 0.0f && sum <= diffuse)
        g->p_diffuse = 1.0f; /* whatever division makes of it */
    g->p_through = through * scale;
    g->p_matched = matched * scale;
    g->p_facet = facet * scale;
}

static void see(const struct bsdf *b, const float wo[3], struct gltf *g)
{
    const float dielectric = 1.0f - b->metallic;
    roughness_of(b, g->alpha);
    g->smooth = roughness_is_smooth(b);
    g->metal = b->metallic;
    g->clear_share = dielectric * b->transmission;
    g->opaque = dielectric - g->clear_share;
    g->clear = clear_kind_of(b, g->clear_share);
    const float root = g->clear == CLEAR_BENT ? (b->ior - 1.0f) / (b->ior + 1.0f) : 0.0f;
    g->index_f0 = root * root;
    g->most_f0 = most_of(b->specular_f0);
    g->span = ggx_span(wo, g->alpha);
    const float grazing = mean_grazing(g, wo);
    const float kept = 1.0f - hindrance(b, g, grazing);
    g->kept = kept > 0.0f ? kept : 0.0f;
    choose(b, g, wo, grazing);
}

/* Returns the diffuse lobe over its albedo. */
static float diffuse(const struct bsdf *b, const struct gltf *g, const float wi[3])
{
    if (b->specular <= 0.0f) return LAMBERT_INV_PI;
    const float average =
        g->smooth ? FRESNEL_GRAZING_MEAN : coupling_average(sqrtf(g->alpha[0] * g->alpha[1]));
    const float in = 1.0f - hindrance(b, g, mean_grazing(g, wi));
    const float all =
        1.0f - (film_is_on(b) ? b->specular * b->film_mean : hindrance(b, g, average));
    return in > 0.0f && all > 1e-6f ? LAMBERT_INV_PI * g->kept * in / all : 0.0f;
}

/* Adds light that facets reflect; `wi` above the surface. Through a thin wall (`through`) it is
 * what they would reflect into the mirrored direction. */
static void add_mirrored(const struct bsdf *b, const struct gltf *g, const float wo[3],
                         const float wi[3], bool through, struct bsdf_value *out)
{
    float h[3];
    struct facet f;
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float cosine = 0.5f * twice, d = ggx_facets(h, g->alpha);
    const float value = d * ggx_visibility(wo[2], g->span, wi[2], ggx_span(wi, g->alpha));
    facet_of(b, g, cosine, fresnel_grazing(cosine), &f);
    const float *color = through ? f.transmit : f.reflect;
    for (int k = 0; k < 3; k++) out->specular[k] += color[k] * value;
    const float p = through ? 1.0f - f.p_reflect : f.p_reflect;
    out->pdf += g->p_facet * p * 0.25f * d * ggx_seen(wo[2], g->span);
}

/* Adds light that facets refract; wi below the surface. */
static void add_refracted(const struct bsdf *b, const struct gltf *g, const float wo[3],
                          const float wi[3], struct bsdf_value *out)
{
    float h[3];
    struct facet f;
    const float eta = b->ior;
    const float length =
        direction_normalize(wo[0] + eta * wi[0], wo[1] + eta * wi[1], wo[2] + eta * wi[2], h);
    if (h[2] < 0.0f) direction_set(-h[0], -h[1], -h[2], h);
    const float cosine = direction_dot(wo, h), cosine_i = -direction_dot(wi, h);
    if (!(length > 0.0f && cosine > 0.0f && cosine_i > 0.0f)) return;
    facet_of(b, g, cosine, fresnel_grazing(cosine), &f);
    const float d = ggx_facets(h, g->alpha);
    const float below[3] = {wi[0], wi[1], -wi[2]};
    /* of directions per facet: dh = eta^2 |wi.h| / |wo + eta wi|^2 dwi */
    const float bend = eta / length, jacobian = bend * bend * cosine_i * cosine * d;
    const float value =
        4.0f * jacobian * ggx_visibility(wo[2], g->span, below[2], ggx_span(below, g->alpha));
    for (int k = 0; k < 3; k++) out->specular[k] += f.transmit[k] * value;
    out->pdf += g->p_facet * (1.0f - f.p_reflect) * jacobian * ggx_seen(wo[2], g->span);
}

/* Leaves of what is transmitted the colour for which it is. */
static void filter(const struct bsdf *b, const float wi[3], float specular[3])
{
    if (!b->dispersed || b->color == BSDF_ALL_COLORS || wi[2] >= 0.0f) return;
    for (int k = 0; k < 3; k++) specular[k] = k == b->color ? b->color_scale * specular[k] : 0.0f;
}

static void evaluate_seen(const struct bsdf *b, const struct gltf *g, const float wo[3],
                          const float wi[3], struct bsdf_value *out)
{
    *out = (struct bsdf_value){0};
    const bool facets = g->p_facet > 0.0f && !g->smooth;
    if (wi[2] > 0.0f) {
        if (g->p_diffuse > 0.0f) {
            out->diffuse = diffuse(b, g, wi);
            out->pdf = lobe_diffuse_pdf(g->p_diffuse, wi[2]);
        }
        if (facets) add_mirrored(b, g, wo, wi, false, out);
        return;
    }
    const float above[3] = {wi[0], wi[1], -wi[2]};
    if (g->p_through > 0.0f) {
        const float value = diffuse(b, g, above);
        for (int k = 0; k < 3; k++) out->specular[k] = b->through[k] * value;
        out->pdf = lobe_diffuse_pdf(g->p_through, above[2]);
    }
    if (facets && g->clear == CLEAR_THIN) add_mirrored(b, g, wo, above, true, out);
    if (facets && g->clear == CLEAR_BENT) add_refracted(b, g, wo, wi, out);
}

void gltf_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out)
{
    struct gltf g;
    see(b, wo, &g);
    evaluate_seen(b, &g, wo, wi, out);
    filter(b, wi, out->specular);
}

/* Lets light straight through. */
static bool pass(const struct bsdf *b, const struct gltf *g, const float wo[3],
                 struct bsdf_sample *out)
{
    direction_set(-wo[0], -wo[1], -wo[2], out->wi);
    for (int k = 0; k < 3; k++) out->specular[k] = g->clear_share * b->base_color[k] / g->p_matched;
    filter(b, out->wi, out->specular);
    out->dirac = out->transmitted = true;
    return true;
}

/* Computes the direction into which a facet sends wo; false where that is on the wrong side. */
static bool leave(const struct bsdf *b, const struct gltf *g, const float wo[3], const float h[3],
                  float choice, struct facet *f, struct bsdf_sample *out)
{
    const float cosine = direction_dot(wo, h);
    facet_of(b, g, cosine, fresnel_grazing(cosine), f);
    out->transmitted = f->p_reflect < 1.0f && choice >= f->p_reflect; /* choice may round to 1 */
    if (!out->transmitted || g->clear == CLEAR_THIN) {
        direction_reflect(wo, h, cosine, out->wi);
        if (out->wi[2] <= 0.0f) return false;
        if (out->transmitted) out->wi[2] = -out->wi[2];
        return true;
    }
    if (f->cosine_far <= 0.0f) return false;
    direction_refract(wo, h, cosine, f->cosine_far, b->ior, out->wi);
    return out->wi[2] < 0.0f;
}

/* Samples a smooth surface, whose facets are the surface itself. */
static bool leave_smooth(const struct bsdf *b, const struct gltf *g, const float wo[3],
                         float choice, struct bsdf_sample *out)
{
    static const float normal[3] = {0.0f, 0.0f, 1.0f};
    struct facet f;
    if (!leave(b, g, wo, normal, choice, &f, out)) return false;
    const float p = g->p_facet * (out->transmitted ? 1.0f - f.p_reflect : f.p_reflect);
    const float *color = out->transmitted ? f.transmit : f.reflect;
    if (!(p > 0.0f)) return false;
    for (int k = 0; k < 3; k++) out->specular[k] = color[k] / p;
    filter(b, out->wi, out->specular);
    out->dirac = true;
    return true;
}

bool gltf_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 struct bsdf_sample *out, struct bsdf_value *value)
{
    struct gltf g;
    see(b, wo, &g);
    const float p_through = g.p_diffuse + g.p_through, p_matched = p_through + g.p_matched;
    if (choice < p_through) {
        lambert_direction(u[0], u[1], &out->wi[0], &out->wi[1], &out->wi[2]);
        if (choice >= g.p_diffuse) out->wi[2] = -out->wi[2];
    } else if (choice < p_matched) {
        return pass(b, &g, wo, out);
    } else if (g.p_facet > 0.0f) {
        /* what is left of the choice decides between reflection and transmission */
        const float rest = (choice - p_through - g.p_matched) / g.p_facet;
        float h[3];
        struct facet f;
        if (g.smooth) return leave_smooth(b, &g, wo, rest, out);
        ggx_sample(wo, g.alpha, u, h);
        if (!leave(b, &g, wo, h, rest, &f, out)) return false;
    } else {
        return false;
    }
    if (fabsf(out->wi[2]) < DIRECTION_GRAZING) return false;
    evaluate_seen(b, &g, wo, out->wi, value);
    filter(b, out->wi, value->specular);
    return true;
}
