#pragma once
/* Materials as this version shades them: Lambert, with the base colour as diffuse albedo (metals
 * too, so that they are not black), emission, alpha tests and normal maps.
 *
 * An unlit material emits its base colour to both sides and reflects nothing. */
#include <stdbool.h>

#include "worker/scene/texture.h"

struct material {
    float base_color[4];
    float emission[3];
    float normal_scale;
    float alpha_cutoff; /* surfaces with less alpha are not there; 0: opaque */
    bool emissive, double_sided, unlit;
    bool textured; /* reads UVs at all */
    struct texture base_color_texture, normal_texture, emission_texture;
};

struct material_table {
    struct texture_decoding decoding;
    uint32_t count;
    struct material materials[];
};

/* All materials of a blob, which must outlive the table. ERR_MEMORY. */
int material_table_create(const struct scene *blob, struct material_table **out);
void material_table_destroy(struct material_table **table);

/* Where on a mesh: both UV sets at the hit. */
struct material_uv {
    float set[2][2];
};

/* Base colour, linear, alpha last. */
void material_base_color(const struct material *m, const struct material_uv *uv, float out[4]);

/* Emitted radiance of the side that emits; of unlit materials the base colour. */
void material_emission(const struct material *m, const struct material_uv *uv, float out[3]);

/* The normal map's normal in tangent space, not normalised. The material must have one. */
void material_tangent_normal(const struct material *m, const struct material_uv *uv, float out[3]);
