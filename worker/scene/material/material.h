#pragma once
/* Materials as paths meet them: a record of the blob with its textures looked up, from which every
 * hit makes the BSDF of its point (material_bsdf).
 *
 * Sources: glTF 2.0, section 3.9 and appendix B; KHR_materials_specular, _ior, _transmission,
 * _volume, _anisotropy, _clearcoat, _emissive_strength, _unlit. An unlit material emits its base
 * colour to both sides and reflects nothing. Rays meet materials from both sides, double-sided or
 * not. Only emission and cameras (back_faces.h) tell the sides apart. */
#include <stdbool.h>

#include "worker/scene/material/texture.h"
#include "worker/shade/bsdf.h"

struct material {
    float base_color[4];
    float emission[3];
    float normal_scale;
    float alpha_cutoff; /* surfaces with less alpha are not there; 0: opaque */
    bool emissive, double_sided, unlit;
    bool culled;       /* camera rays pass its back (back_faces.h) */
    bool textured;     /* reads UVs or vertex colours at all */
    bool colored;      /* vertex colours multiply its base colour */
    bool lambert;      /* its BSDF is a Lambertian one wherever it is hit */
    bool anisotropic;  /* its BSDF depends on material_tangent_angle */
    bool transmissive; /* may send paths through */
    bool translucent;  /* may send them on from its far side as a diffuse surface does */
    bool volume;       /* a closed solid with an inside; false: thin-walled, if paths pass it */
    bool blend;        /* of partial opacity somewhere (alpha.h) */
    uint32_t model;    /* enum material_model */
    float metallic, roughness, transmission, specular;
    float dispersion;           /* KHR_materials_dispersion; of volumes only */
    float ior;                  /* of the inside over the outside; 0: infinite */
    float specular_f0[3];       /* ((ior - 1) / (ior + 1))^2 times the colour; beyond 1 too */
    float coat, coat_roughness; /* KHR_materials_clearcoat */
    bool coat_bent;             /* normals of the coat may not be the surface's: a map bends
                                   one of the two */
    float coat_normal_scale;
    bool has_sheen;
    float sheen[3], sheen_roughness;  /* KHR_materials_sheen */
    float through, through_color[3];  /* KHR_materials_diffuse_transmission */
    float film, film_ior, film_nm[2]; /* KHR_materials_iridescence; thickness from and to */
    float anisotropy, rotation[2];    /* strength; cosine, sine */
    float model_specular[3];
    float exponent_u, exponent_v, alpha_u, alpha_v;
    float second_specular[3], second_alpha, grazing[2];
    float eta[3], k[3];
    float absorption[3];        /* -log of the transmittance over attenuation_distance */
    float attenuation_distance; /* scene units; 0: clear */
    float shown[3];       /* struct surface's albedo, but for Lambert surfaces with textures */
    struct bsdf plain[2]; /* from outside, from inside; of materials that are not textured */
    struct texture base_color_texture, normal_texture, emission_texture;
    struct texture metallic_roughness_texture, transmission_texture, specular_texture,
        specular_color_texture, anisotropy_texture, coat_texture, coat_roughness_texture,
        coat_normal_texture, sheen_texture, sheen_roughness_texture, through_texture,
        through_color_texture, film_texture, film_nm_texture;
};

struct material_table {
    struct texture_decoding decoding;
    uint32_t count;
    struct material materials[];
};

/* Creates the table of all materials of a blob, which must outlive it. ERR_MEMORY. */
int material_table_create(const struct scene *blob, struct material_table **out);
void material_table_destroy(struct material_table **table);

/* A place on a mesh: both UV sets and the vertex colour at the hit. Materials that are not
 * `textured` read none: NULL will do. */
struct material_uv {
    float set[2][2];
    float color[4];
};

/* Computes the base colour, linear, alpha last. */
void material_base_color(const struct material *m, const struct material_uv *uv, float out[4]);

/* Returns how much of the surface is there, in [0, 1]: 1 if opaque, 0 or 1 of a mask, alpha of a
 * blend. */
float material_opacity(const struct material *m, const struct material_uv *uv);

/* Computes the emitted radiance of the side that emits; for unlit materials the base colour. */
void material_emission(const struct material *m, const struct material_uv *uv, float out[3]);

/* Computes the emitted radiance averaged over the emission texture: what the mesh would emit on the
 * whole if its UVs covered the texture evenly. It reads every texel, so it is for preparations. */
void material_mean_emission(const struct material *m, float out[3]);

/* Computes the normal map's normal in tangent space, not normalised; (0, 0, 1) without a map. */
void material_tangent_normal(const struct material *m, const struct material_uv *uv, float out[3]);

/* Does the same from the normal map's texel there. */
void material_bend(const struct material *m, const float texel[4], float out[3]);

/* Computes the coat's normal in tangent space, not normalised. */
void material_coat_normal(const struct material *m, const struct material_uv *uv, float out[3]);

/* Returns whether its diffuse albedo is its base colour times what metalness leaves of it. */
bool material_is_metallic_only(const struct material *m);

/* Computes the BSDF at a point, in the frame whose x is the mesh's tangent turned by
 * material_tangent_angle. `inside`: the path is inside the solid; it matters only for a `volume`.
 * Every field of *out is set, within bsdf.h's ranges. */
void material_bsdf(const struct material *m, const struct material_uv *uv, bool inside,
                   struct bsdf *out);

/* Computes the cosine and sine of the angle from the mesh's tangent, towards its bitangent, at
 * which the facets of an anisotropic surface are widest spread (alpha_u). (1, 0) where
 * !anisotropic. */
void material_tangent_angle(const struct material *m, const struct material_uv *uv,
                            float direction[2]);

/* Returns the share of light that is left after `distance` scene units inside the solid: Beer
 * and Lambert's law, attenuation ^ (distance / attenuation_distance). Ones where it is clear. */
void material_attenuation(const struct material *m, float distance, float transmittance[3]);
