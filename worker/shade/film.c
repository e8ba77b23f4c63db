#include "worker/shade/film.h"

#include "worker/shade/coupling.h"
#include "worker/shade/elementary.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/roughness.h"

/* Thinner films fade into the air. */
#define THIN_NM 0.03f

/* Reflections within the film beside the mean. */
#define ORDERS 2

/* One Gaussian of the eye's sensitivity over wave numbers (1/m), in units of the luminous white's
 * integral: height sqrt(2 pi variance), mean, variance. X has two; Y and Z have one. */
struct gaussian {
    float height, mean, variance;
};
static const struct gaussian sensitivity[4] = {{0.846590f, 1.6810e+06f, 4.3278e+09f},
                                               {0.153868f, 2.2399e+06f, 4.5282e+09f},
                                               {1.000222f, 1.7953e+06f, 9.3046e+09f},
                                               {1.001122f, 2.2084e+06f, 6.6121e+09f}};

/* From the response to a path difference, as X, Y, Z, to Rec. 709's primaries. */
static const float rec709[3][3] = {{3.2404542f, -1.5371385f, -0.4985314f},
                                   {-0.9692660f, 1.8760108f, 0.0415560f},
                                   {0.0556434f, -0.2040259f, 1.0572252f}};

/* The film as light finds it. */
struct film {
    float ior;
    float cosine_in; /* within it */
    float outer;     /* reflectance of its outer side */
    float turn_m;    /* 2 pi times the difference of two successive paths */
};

static float respond(const struct gaussian *g, float turn)
{
    return g->height * elementary_cos(g->mean * turn) * elementary_exp(-g->variance * turn * turn);
}

static float clamp(float v, float low, float high)
{
    return v < low ? low : v > high ? high : v;
}

/* Returns 1 - cosine of a grazing (1 - cosine)^5. */
static float depth_of(float grazing)
{
    return grazing > 0.0f ? elementary_exp(0.2f * elementary_log(grazing)) : 0.0f;
}

static float f0_between(float inner, float outer)
{
    const float root = (inner - outer) / (inner + outer);
    return root * root;
}

static void enter(const struct bsdf *b, float grazing, struct film *f)
{
    const float t = clamp(b->film_nm / THIN_NM, 0.0f, 1.0f), smooth = t * t * (3.0f - 2.0f * t);
    const float depth = depth_of(grazing);
    f->ior = 1.0f + (b->film_ior - 1.0f) * smooth;
    const float sine2 = depth * (2.0f - depth) / (f->ior * f->ior);
    f->cosine_in = sqrtf(sine2 < 1.0f ? 1.0f - sine2 : 0.0f);
    f->outer = fresnel_schlick(f0_between(f->ior, 1.0f), grazing);
    f->turn_m = 2.0f * ELEMENTARY_PI * 2.0f * f->ior * b->film_nm * f->cosine_in * 1e-9f;
}

/* The film's inner side over a base that reflects f0 in air. *alike: light within loses half a wave
 * at neither side. */
static float inner_side(const struct film *f, float f0, bool *alike)
{
    const float root = sqrtf(clamp(f0, 0.0f, 0.9999f)), ior = (1.0f + root) / (1.0f - root);
    *alike = ior < f->ior;
    return fresnel_schlick(f0_between(ior, f->ior), fresnel_grazing(f->cosine_in));
}

/* Computes the light that is reflected m times in the film, as a colour. Odd orders change their
 * sign where half a wave is alike at the inner side. */
static void order_color(const struct film *f, int m, const bool alike[3], float out[3])
{
    const float turn = (float)m * f->turn_m;
    float xyz[3] = {respond(&sensitivity[0], turn) + respond(&sensitivity[1], turn),
                    respond(&sensitivity[2], turn), respond(&sensitivity[3], turn)};
    for (int k = 0; k < 3; k++)
        if (m % 2 == 1 && !alike[k]) xyz[k] = -xyz[k];
    for (int k = 0; k < 3; k++)
        out[k] = rec709[k][0] * xyz[0] + rec709[k][1] * xyz[1] + rec709[k][2] * xyz[2];
}

static void interfere(const struct bsdf *b, const float f0[3], float grazing, float out[3])
{
    struct film f;
    float each[3], weight[3];
    bool alike[3];
    enter(b, grazing, &f);
    const float passes = 1.0f - f.outer;
    for (int k = 0; k < 3; k++) {
        const float inner = inner_side(&f, f0[k], &alike[k]);
        const float both = clamp(f.outer * inner, 0.0f, 0.9999f);
        const float sum = passes * passes * inner / (1.0f - both);
        out[k] = f.outer + sum;
        weight[k] = sum - passes;
        each[k] = sqrtf(both);
    }
    for (int m = 1; m <= ORDERS; m++) {
        float color[3];
        order_color(&f, m, alike, color);
        for (int k = 0; k < 3; k++) {
            weight[k] *= each[k];
            out[k] += 2.0f * weight[k] * color[k];
        }
    }
    for (int k = 0; k < 3; k++) out[k] = clamp(out[k], 0.0f, 1.0f);
}

void film_fresnel(const struct bsdf *b, const float f0[3], float grazing, float out[3])
{
    interfere(b, f0, grazing, out);
    for (int k = 0; k < 3; k++) {
        const float bare = fresnel_schlick(f0[k], grazing);
        out[k] = bare + (out[k] - bare) * b->film;
    }
}

void film_prepare(struct bsdf *b)
{
    /* Gauss and Legendre's rule over the square of the cosine, which weighs by the cosine. */
    static const float at[4] = {0.0694318f, 0.3300095f, 0.6699905f, 0.9305682f};
    static const float weight[4] = {0.1739274f, 0.3260726f, 0.3260726f, 0.1739274f};
    float alpha[2];
    roughness_of(b, alpha);
    const bool smooth = roughness_is_smooth(b);
    b->film_mean = 0.0f;
    for (int i = 0; film_is_on(b) && i < 4; i++) {
        const float cosine = sqrtf(at[i]);
        float f[3];
        film_fresnel(b, b->specular_f0,
                     smooth ? fresnel_grazing(cosine)
                            : coupling_grazing(cosine, sqrtf(alpha[0] * alpha[1])),
                     f);
        const float most = f[0] > f[1] ? f[0] : f[1];
        b->film_mean += weight[i] * (most > f[2] ? most : f[2]);
    }
}
