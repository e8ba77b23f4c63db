#include "worker/shade/coat.h"

#include "worker/shade/coupling.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/ggx.h"
#include "worker/shade/lobe.h"
#include "worker/shade/sheen.h"

#define COAT_F0 0.04f

/* What two smooth layers of an index of 1.5 let through of a diffuse surface's light varies with
 * its direction in the same way: the mean of the product is so much above the product of the means.
 * 0.96^2 (1/66 - 1/21^2) / (1 - 0.04 - 0.96/21)^2, of Schlick's (1 - cosine)^5 and its square. */
#define COUPLED 0.0142f

/* The layer as wo sees it. */
struct coat {
    float frame[3][3]; /* two tangents and its normal; only of one that is bent */
    float wo[3];       /* in that frame */
    float alpha[2];    /* the same twice, as ggx.h takes it */
    bool smooth;
    bool reflects; /* not seen from inside a volume */
    float passed;  /* T(wo) */
    float p;       /* of choosing its lobe */
};

/* Returns M(w) of a direction at `cosine`. */
static float hindrance(const struct bsdf *b, const struct coat *c, float cosine)
{
    const float grazing =
        c->smooth ? fresnel_grazing(cosine) : coupling_grazing(cosine, c->alpha[0]);
    return b->coat * fresnel_schlick(COAT_F0, grazing);
}

/* Turns w into the layer's frame. */
static void to_layer(const struct bsdf *b, const struct coat *c, const float w[3], float out[3])
{
    direction_set(w[0], w[1], w[2], out);
    for (int k = 0; b->coat_bent && k < 3; k++) out[k] = direction_dot(w, c->frame[k]);
}

static void from_layer(const struct bsdf *b, const struct coat *c, const float w[3], float out[3])
{
    direction_set(w[0], w[1], w[2], out);
    for (int k = 0; b->coat_bent && k < 3; k++)
        out[k] = w[0] * c->frame[0][k] + w[1] * c->frame[1][k] + w[2] * c->frame[2][k];
}

static float mean_hindrance(const struct bsdf *b, const struct coat *c)
{
    const float grazing = c->smooth ? FRESNEL_GRAZING_MEAN : coupling_average(c->alpha[0]);
    return b->coat * fresnel_schlick(COAT_F0, grazing);
}

/* Estimates what the surface beneath reflects or transmits. Rough facets of a black one reflect a
 * little, too. */
static float beneath(const struct bsdf *b, float cosine)
{
    const float grazing = fresnel_grazing(cosine), dielectric = 1.0f - b->metallic;
    const float facets =
        dielectric * b->specular * fresnel_schlick(lobe_mean(b->specular_f0), grazing) +
        b->metallic * fresnel_schlick(lobe_mean(b->base_color), grazing);
    const float fibres =
        sheen_is_on(b) ? lobe_mean(b->sheen) * sheen_albedo(cosine, b->sheen_alpha) : 0.0f;
    return LOBE_MIN + lobe_mean(b->albedo) + lobe_mean(b->through) + facets + fibres +
           dielectric * b->transmission * lobe_mean(b->base_color);
}

static void see(const struct bsdf *b, const float wo[3], struct coat *c)
{
    c->smooth = b->coat_alpha < BSDF_SMOOTH;
    c->alpha[0] = c->alpha[1] = c->smooth ? BSDF_SMOOTH : b->coat_alpha;
    if (b->coat_bent) {
        const float *n = b->coat_normal;
        direction_set(n[0], n[1], n[2], c->frame[2]);
        direction_frame(n, c->frame[0], c->frame[1]);
    }
    to_layer(b, c, wo, c->wo);
    c->reflects = (!b->inside || b->thin) && c->wo[2] >= DIRECTION_GRAZING;
    const float reflected = hindrance(b, c, fabsf(c->wo[2]));
    c->passed = 1.0f - reflected;
    c->p = c->reflects ? lobe_share(reflected, c->passed * beneath(b, wo[2])) : 0.0f;
    const float seen = lobe_seen_share(b->coat_alpha);
    if (b->seen && c->p > 0.0f && c->p < seen) c->p = seen;
    /* Nor is what is beneath chosen less often. */
    if (c->p > 1.0f - LOBE_MIN) c->p = 1.0f - LOBE_MIN;
}

/* Computes the factors of the lobes beneath. */
static void scale_beneath(const struct bsdf *b, const struct coat *c, const float wi[3],
                          float *diffuse, float *others)
{
    float layer_wi[3];
    to_layer(b, c, wi, layer_wi);
    const float in = 1.0f - hindrance(b, c, fabsf(layer_wi[2]));
    const float lesser = in < c->passed ? in : c->passed;
    const float coupled = 1.0f + COUPLED * b->coat * b->specular;
    *diffuse = c->passed * in / ((1.0f - mean_hindrance(b, c)) * coupled);
    *others = lesser;
    if (b->thin || !(b->inside || wi[2] < 0.0f)) return;
    /* a volume: its outer side alone has the layer */
    *diffuse = 1.0f;
    *others = !b->inside ? c->passed : wi[2] < 0.0f ? in : 1.0f;
}

static void add_coat(const struct bsdf *b, const struct coat *c, const float in[3],
                     struct bsdf_value *out)
{
    float h[3], wi[3];
    const float *wo = c->wo;
    to_layer(b, c, in, wi);
    if (!c->reflects || c->smooth || in[2] <= 0.0f || wi[2] < DIRECTION_GRAZING) return;
    const float twice = direction_normalize(wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2], h);
    const float cosine = 0.5f * twice, d = ggx_facets(h, c->alpha);
    const float span = ggx_span(wo, c->alpha);
    const float value = b->coat * fresnel_schlick(COAT_F0, fresnel_grazing(cosine)) * d *
                        ggx_visibility(wo[2], span, wi[2], ggx_span(wi, c->alpha));
    const float turned = b->coat_bent ? value * (wi[2] / in[2]) : value;
    for (int k = 0; k < 3; k++) out->specular[k] += turned;
    out->pdf += c->p * 0.25f * d * ggx_seen(wo[2], span);
}

/* Adds the layer to what the surface beneath does. */
static void combine(const struct bsdf *b, const struct coat *c, const float wi[3],
                    struct bsdf_value *inout)
{
    float diffuse, others;
    scale_beneath(b, c, wi, &diffuse, &others);
    inout->diffuse *= diffuse;
    for (int k = 0; k < 3; k++) inout->specular[k] *= others;
    inout->pdf *= 1.0f - c->p;
    add_coat(b, c, wi, inout);
}

void coat_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out)
{
    struct coat c;
    see(b, wo, &c);
    sheen_evaluate(b, wo, wi, out);
    combine(b, &c, wi, out);
}

static bool sample_coat(const struct bsdf *b, const struct coat *c, const float wo[3],
                        const float u[2], struct bsdf_sample *out, struct bsdf_value *value)
{
    float h[3], wi[3];
    if (c->smooth) {
        const float share = hindrance(b, c, c->wo[2]) / c->p;
        direction_mirror(c->wo, wi);
        from_layer(b, c, wi, out->wi);
        for (int k = 0; k < 3; k++) out->specular[k] = share;
        out->dirac = true;
        return out->wi[2] >= DIRECTION_GRAZING;
    }
    ggx_sample(c->wo, c->alpha, u, h);
    direction_reflect(c->wo, h, direction_dot(c->wo, h), wi);
    if (wi[2] < DIRECTION_GRAZING) return false;
    from_layer(b, c, wi, out->wi);
    if (out->wi[2] < DIRECTION_GRAZING) return false;
    sheen_evaluate(b, wo, out->wi, value);
    combine(b, c, out->wi, value);
    return true;
}

bool coat_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 struct bsdf_sample *out, struct bsdf_value *value)
{
    struct coat c;
    float diffuse, others;
    see(b, wo, &c);
    if (choice < c.p) return sample_coat(b, &c, wo, u, out, value);
    const float rest = (choice - c.p) / (1.0f - c.p); /* may round to 1, which sheen.c allows for */
    if (!sheen_sample(b, wo, rest, u, out, value)) return false;
    if (!out->dirac) {
        combine(b, &c, out->wi, value);
        return true;
    }
    scale_beneath(b, &c, out->wi, &diffuse, &others);
    for (int k = 0; k < 3; k++) out->specular[k] *= others / (1.0f - c.p);
    return true;
}
