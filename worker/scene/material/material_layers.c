#include "worker/scene/material/material_layers.h"

#include "worker/shade/film.h"

static void set_coat(const struct material *m, const struct material_uv *uv, struct bsdf *out)
{
    float factor[4], rough[4];
    material_texel(&m->coat_texture, uv, factor);
    material_texel(&m->coat_roughness_texture, uv, rough);
    const float roughness = m->coat_roughness * rough[1];
    out->coat = m->coat * factor[0];
    out->coat_alpha = roughness * roughness;
}

static void set_sheen(const struct material *m, const struct material_uv *uv, struct bsdf *out)
{
    float color[4], rough[4];
    material_texel(&m->sheen_texture, uv, color);
    material_texel(&m->sheen_roughness_texture, uv, rough);
    const float roughness = m->sheen_roughness * rough[3];
    for (int i = 0; i < 3; i++) out->sheen[i] = m->sheen[i] * color[i];
    out->sheen_alpha = roughness * roughness;
}

/* Red bends less than what the index is of, blue more. */
static void disperse(const struct material *m, struct bsdf *out)
{
    const float half = (m->ior - 1.0f) * 0.025f * m->dispersion;
    for (int i = 0; i < 3; i++) {
        const float ior = m->ior + (float)(i - 1) * half;
        out->iors[i] = ior < 1.0f ? 1.0f : ior;
        if (out->inside) out->iors[i] = 1.0f / out->iors[i];
    }
    out->dispersed = true;
    out->color = BSDF_ALL_COLORS;
}

static void set_film(const struct material *m, const struct material_uv *uv, struct bsdf *out)
{
    float factor[4], thickness[4];
    material_texel(&m->film_texture, uv, factor);
    material_texel(&m->film_nm_texture, uv, thickness);
    out->film = m->film * factor[0];
    out->film_ior = m->film_ior;
    out->film_nm = m->film_nm[0] + (m->film_nm[1] - m->film_nm[0]) * thickness[1];
    film_prepare(out);
}

static void set_through(const struct material *m, const struct material_uv *uv, struct bsdf *out)
{
    float factor[4], color[4];
    material_texel(&m->through_texture, uv, factor);
    material_texel(&m->through_color_texture, uv, color);
    const float through = m->through * factor[3];
    for (int i = 0; i < 3; i++) {
        out->through[i] = through * m->through_color[i] * color[i] * (1.0f - out->metallic) *
                          (1.0f - out->transmission);
        out->albedo[i] *= 1.0f - through;
    }
}

void material_layers_set(const struct material *m, const struct material_uv *uv, struct bsdf *out)
{
    if (m->coat > 0.0f) set_coat(m, uv, out);
    if (m->has_sheen) set_sheen(m, uv, out);
    if (m->translucent) set_through(m, uv, out);
    if (m->film > 0.0f) set_film(m, uv, out);
    if (m->dispersion > 0.0f && m->transmissive && m->volume && m->ior > 1.0f) disperse(m, out);
}
