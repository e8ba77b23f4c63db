#pragma once
/* A surface's scattering of light at one point: a sum of lobes, which are evaluated and sampled,
 * and their density.
 *
 * Directions are unit, in the shading frame: z is the shading normal, turned to the side that the
 * path came from, x and y the tangents that anisotropy refers to. wo points back along the path
 * (wo.z > 0), wi on along it: wi.z > 0 is a reflection, wi.z < 0 a transmission. Values are the
 * BSDF's, without the cosine; densities are per solid angle.
 *
 * The diffuse lobe is kept apart and without its albedo, so that lighting can be filtered and
 * textures applied afterwards: f = albedo * diffuse + specular, where `specular` holds all else.
 *
 * All functions are pure, use no mathematics of the C library beyond sqrtf, floorf and fabsf (whose
 * results do not depend on the CPU), and give finite numbers for every struct bsdf within the
 * ranges below. Each model has a file with its formulas; bsdf.c only chooses. */
#include <stdbool.h>
#include <stdint.h>

enum bsdf_model {
    BSDF_BLACK = 0,   /* reflects nothing: emitters, unlit */
    BSDF_LAMBERT = 1, /* albedo */
#define MODEL(number, NAME, name) BSDF_##NAME = 2 + (number), /* enum material_model's */
#include "proto/scene/model.def"
    BSDF_MODEL_COUNT
};

struct bsdf {
    enum bsdf_model model;
    float
        albedo[3]; /* of the diffuse lobe, [0, 1]; glTF: base colour (1-metallic)(1-transmission)
                      (1-diffuse transmission); Ashikhmin-Shirley: base colour (1-model_specular) */
    float alpha_u, alpha_v; /* roughness of facets, [0, 1]; below BSDF_SMOOTH it is a mirror's */
    /* glTF */
    float base_color[3];
    float metallic, transmission;  /* [0, 1] */
    float specular;                /* KHR_materials_specular factor */
    float through[3];              /* albedo of KHR_materials_diffuse_transmission's lobe */
    float film, film_ior, film_nm; /* KHR_materials_iridescence: factor, index >= 1, thickness */
    float film_mean;               /* film.h */
    float specular_f0[3];          /* min(((ior-1)/(ior+1))^2 specular colour, 1) */
    float ior;     /* of the far side over the near one, as the path meets it: 1/ior from inside */
    float iors[3]; /* KHR_materials_dispersion: the same of each colour; only where dispersed */
    bool dispersed;
    int color;         /* of dispersed volumes: the one that is transmitted, by its own index, which
                          `ior` is, too; BSDF_ALL_COLORS: all, by one index */
    float color_scale; /* its weight, where it stands for the others */
    float coat, coat_alpha; /* KHR_materials_clearcoat: factor, roughness of its facets; [0, 1] */
    float coat_normal[3];   /* unit; only where coat_bent */
    float sheen[3], sheen_alpha; /* KHR_materials_sheen: colour, roughness of its fibres; [0, 1] */
    bool coat_bent;              /* the coat has a normal of its own */
    bool thin;                   /* thin-walled: what is transmitted is not bent */
    bool seen;                   /* by the camera, to which sharp lobes matter more (lobe.h) */
    float turn_least; /* least probability of reflection and of transmission, of clear glass that
                         the camera sees; [0, 1/2] */
    bool inside;      /* the path is inside the volume and meets its surface from behind */
    /* others */
    float model_specular[3];                            /* [0, 1] */
    float exponent_u, exponent_v;                       /* [0, 1e5] */
    float second_specular[3], second_alpha, grazing[2]; /* measured.h; [0, 1] */
    float eta[3], k[3]; /* eta[0] > 0: a conductor times model_specular; else Schlick */
};

#define BSDF_ALL_COLORS (-1)

#define BSDF_SMOOTH 1e-4f /* facets of a smaller alpha are one plane: a Dirac lobe */

/* Directions of a smaller density are not sampled: weights would overflow. */
#define BSDF_PDF_MIN 1e-30f

struct bsdf_value {
    float
        diffuse; /* the diffuse lobe over its albedo; 0 where albedo is black beside other lobes */
    float specular[3]; /* all other lobes that are no Dirac lobes */
    float pdf;         /* of bsdf_sample choosing wi, Dirac lobes aside */
};

struct bsdf_sample {
    float wi[3];
    float diffuse;     /* weight: f |cos| / pdf of the diffuse lobe over its albedo */
    float specular[3]; /* the same of all others */
    float pdf;         /* of all lobes together; 0 for a Dirac lobe */
    bool dirac;        /* the lobe is a Dirac one; weights are its reflectance / probability */
    bool transmitted;
};

/* Computes the colour, each component in [0, 2], by which all lobes but the diffuse one reflect at
 * normal incidence or transmit. Dividing by it takes textures of such lobes out. */
void bsdf_tint(const struct bsdf *b, float out[3]);

/* Returns the roughness by which what lobes show is as sharp as it gets: of facets, or of as much
 * of a coat as there is. */
static inline float bsdf_sharpest_alpha(const struct bsdf *b)
{
    const float facets = 0.5f * (b->alpha_u + b->alpha_v);
    return b->coat > 0.0f && b->coat_alpha < facets ? facets + b->coat * (b->coat_alpha - facets)
                                                    : facets;
}

/* Returns whether light leaves the far side as from a diffuse surface. */
static inline bool bsdf_is_translucent(const struct bsdf *b)
{
    return b->through[0] + b->through[1] + b->through[2] > 0.0f;
}

/* Returns whether there is a film, or a lobe beside the diffuse one and those of facets. */
static inline bool bsdf_has_layers(const struct bsdf *b)
{
    return b->coat > 0.0f || b->sheen[0] + b->sheen[1] + b->sheen[2] > 0.0f || b->film > 0.0f ||
           bsdf_is_translucent(b);
}

/* Makes a dispersed volume transmit one colour only, scaled. Chosen by chance among the three and
 * scaled by 3, it has the mean of all. Reflected light keeps all colours. */
static inline void bsdf_choose_color(struct bsdf *b, int color, float scale)
{
    b->color = color;
    b->color_scale = scale;
    b->ior = b->iors[color];
}

/* Returns whether all lobes are Dirac ones: of mirrors and clear glass. */
bool bsdf_is_dirac(const struct bsdf *b);

/* Returns whether a Dirac surface reflects more of what comes along wo, at this cosine, than it
 * transmits. */
bool bsdf_reflects_max(const struct bsdf *b, float cosine);

/* Computes both lobes' values for the pair, and the density with which bsdf_sample chooses wi. They
 * are zero where wo or wi grazes (|z| < 1e-6). */
void bsdf_evaluate(const struct bsdf *b, const float wo[3], const float wi[3],
                   struct bsdf_value *out);

/* Chooses a direction with `choice` (the lobe) and u, all uniform in [0, 1). False: absorbed (the
 * sample's weight is zero: black, or a direction below the horizon). */
bool bsdf_sample(const struct bsdf *b, const float wo[3], float choice, const float u[2],
                 struct bsdf_sample *out);
