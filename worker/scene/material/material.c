#include "worker/scene/material/material.h"

#include <stdlib.h>
#include <string.h>

#include "worker/scene/material/material_layers.h"
#include "worker/shade/elementary.h"

/* Rays without a key (alpha.h) meet blended surfaces as if they were masks. */
#define BLEND_CUTOFF 0.5f

/* Absorption times distance in units of the material's own; e^-87 is the least float. */
#define DISTANCES_MAX 1e6f

static float unit_interval(float v)
{
    return v < 0.0f ? 0.0f : v > 1.0f ? 1.0f : v;
}

/* Returns the lowest opacity anywhere; that of vertices may be any. */
static float least_alpha(const struct material *m)
{
    if (m->colored) return 0.0f;
    const struct texture *t = &m->base_color_texture;
    return m->base_color[3] * (t->texels ? texture_min_alpha(t) : 1.0f);
}

/* Tests for alpha run only where a surface can be transparent. */
static void init_alpha(struct material *m, const struct scene_material *s)
{
    m->alpha_cutoff = 0.0f;
    if (s->alpha_mode == ALPHA_OPAQUE) return;
    float least = least_alpha(m);
    float cutoff = s->alpha_mode == ALPHA_MASK ? s->alpha_cutoff : BLEND_CUTOFF;
    m->blend = s->alpha_mode == ALPHA_BLEND && least < 1.0f;
    if (m->blend || least < cutoff) m->alpha_cutoff = cutoff;
}

static void init_textures(struct material *m, const struct scene *blob,
                          const struct scene_material *s, const struct texture_decoding *decoding)
{
    const struct {
        struct texture *texture;
        const struct scene_texture_ref *ref;
    } all[] = {{&m->base_color_texture, &s->base_color_texture},
               {&m->normal_texture, &s->normal_texture},
               {&m->emission_texture, &s->emission_texture},
               {&m->metallic_roughness_texture, &s->metallic_roughness_texture},
               {&m->transmission_texture, &s->transmission_texture},
               {&m->specular_texture, &s->specular_texture},
               {&m->specular_color_texture, &s->specular_color_texture},
               {&m->anisotropy_texture, &s->anisotropy_texture},
               {&m->coat_texture, &s->clearcoat_texture},
               {&m->coat_roughness_texture, &s->clearcoat_roughness_texture},
               {&m->coat_normal_texture, &s->clearcoat_normal_texture},
               {&m->sheen_texture, &s->sheen_color_texture},
               {&m->sheen_roughness_texture, &s->sheen_roughness_texture},
               {&m->film_texture, &s->iridescence_texture},
               {&m->film_nm_texture, &s->iridescence_thickness_texture},
               {&m->through_texture, &s->diffuse_transmission_texture},
               {&m->through_color_texture, &s->diffuse_transmission_color_texture}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        texture_init(all[i].texture, blob, all[i].ref, decoding);
        m->textured |= all[i].texture->texels != NULL;
    }
}

static void init_gltf(struct material *m, const struct scene_material *s)
{
    m->metallic = s->metallic;
    m->roughness = s->roughness;
    m->transmission = s->transmission;
    m->specular = s->specular;
    m->ior = s->ior;
    float ratio = (s->ior - 1.0f) / (s->ior + 1.0f); /* ior >= 0; 0 gives 1, as the format says */
    for (int i = 0; i < 3; i++) m->specular_f0[i] = ratio * ratio * s->specular_color[i];
    m->anisotropy = s->anisotropy;
    m->coat = s->clearcoat;
    m->coat_roughness = s->clearcoat_roughness;
    m->coat_normal_scale = s->clearcoat_normal_scale;
    m->coat_bent = m->coat > 0.0f && (m->coat_normal_texture.texels || m->normal_texture.texels);
    memcpy(m->sheen, s->sheen_color, sizeof m->sheen);
    m->sheen_roughness = s->sheen_roughness;
    m->dispersion = s->dispersion;
    m->film = s->iridescence;
    m->film_ior = s->iridescence_ior;
    memcpy(m->film_nm, s->iridescence_nm, sizeof m->film_nm);
    m->through = s->diffuse_transmission;
    memcpy(m->through_color, s->diffuse_transmission_color, sizeof m->through_color);
    m->has_sheen = m->sheen[0] > 0.0f || m->sheen[1] > 0.0f || m->sheen[2] > 0.0f;
    m->rotation[0] = elementary_cos(s->anisotropy_rad);
    m->rotation[1] = elementary_sin(s->anisotropy_rad);
}

static void init_others(struct material *m, const struct scene_material *s)
{
    memcpy(m->model_specular, s->model_specular, sizeof m->model_specular);
    m->exponent_u = s->exponent_u;
    m->exponent_v = s->exponent_v;
    m->alpha_u = s->alpha_u;
    m->alpha_v = s->alpha_v;
    memcpy(m->second_specular, s->second_specular, sizeof m->second_specular);
    m->second_alpha = s->second_alpha;
    memcpy(m->grazing, s->grazing, sizeof m->grazing);
    memcpy(m->eta, s->eta, sizeof m->eta);
    memcpy(m->k, s->k, sizeof m->k);
}

/* Sets what paths ask about the whole material. */
static void init_kind(struct material *m, const struct scene_material *s)
{
    bool gltf = s->model == MODEL_GLTF && !m->unlit;
    m->lambert = gltf && m->metallic == 0.0f && m->transmission == 0.0f && m->specular == 0.0f &&
                 m->coat == 0.0f && !m->has_sheen && m->through == 0.0f;
    m->transmissive = gltf && m->transmission > 0.0f && m->metallic < 1.0f;
    m->transmissive |= gltf && m->transmission > 0.0f && m->metallic_roughness_texture.texels;
    m->translucent = gltf && m->through > 0.0f;
    m->volume = (m->transmissive || m->translucent) && s->thickness > 0.0f;
    m->anisotropic = (gltf && !m->lambert && m->anisotropy > 0.0f) ||
                     s->model == MODEL_ASHIKHMIN_SHIRLEY || s->alpha_u != s->alpha_v;
    m->attenuation_distance = m->volume ? s->attenuation_distance : 0.0f;
    for (int i = 0; i < 3; i++) {
        float left = s->attenuation[i]; /* in (0, 1] */
        m->absorption[i] = left < 1.0f && left > 0.0f ? -elementary_log(left) : 0.0f;
    }
}

void material_base_color(const struct material *m, const struct material_uv *uv, float out[4])
{
    memcpy(out, m->base_color, 4 * sizeof out[0]);
    for (int i = 0; m->colored && i < 4; i++) out[i] *= uv->color[i];
    if (!m->base_color_texture.texels) return;
    float texel[4];
    material_texel(&m->base_color_texture, uv, texel);
    for (int i = 0; i < 4; i++) out[i] *= texel[i];
}

/* glTF's roughness is the root of the facets' alpha; anisotropy widens it along the tangent. */
static void set_alphas(const struct material *m, const struct material_uv *uv, float roughness,
                       struct bsdf *out)
{
    float alpha = roughness * roughness;
    out->alpha_u = out->alpha_v = alpha;
    if (!m->anisotropic) return;
    float texel[4];
    material_texel(&m->anisotropy_texture, uv, texel);
    float strength = m->anisotropy * texel[2];
    out->alpha_u = unit_interval(alpha + (1.0f - alpha) * strength * strength);
}

static void set_gltf(const struct material *m, const struct material_uv *uv, bool inside,
                     struct bsdf *out)
{
    float rough[4], through[4], specular[4], tint[4];
    material_texel(&m->metallic_roughness_texture, uv, rough);
    material_texel(&m->transmission_texture, uv, through);
    material_texel(&m->specular_texture, uv, specular);
    material_texel(&m->specular_color_texture, uv, tint);
    out->model = BSDF_GLTF;
    out->metallic = m->metallic * rough[2];
    out->transmission = m->transmissive ? m->transmission * through[0] : 0.0f;
    out->specular = m->specular * specular[3];
    for (int i = 0; i < 3; i++) {
        out->specular_f0[i] = unit_interval(m->specular_f0[i] * tint[i]);
        out->albedo[i] = out->base_color[i] * (1.0f - out->metallic) * (1.0f - out->transmission);
    }
    set_alphas(m, uv, m->roughness * rough[1], out);
    out->inside = inside && m->volume;
    out->ior = out->inside && m->ior > 0.0f ? 1.0f / m->ior : m->ior;
    out->thin = (m->transmissive || m->translucent) && !m->volume;
    material_layers_set(m, uv, out);
}

static void set_model(const struct material *m, struct bsdf *out)
{
    out->model = (enum bsdf_model)(BSDF_GLTF + m->model); /* bsdf.h counts them alike */
    memcpy(out->model_specular, m->model_specular, sizeof out->model_specular);
    out->exponent_u = m->exponent_u;
    out->exponent_v = m->exponent_v;
    out->alpha_u = m->alpha_u;
    out->alpha_v = m->alpha_v;
    if (out->model == BSDF_ASHIKHMIN_SHIRLEY) /* its diffuse lobe is what the other leaves */
        for (int i = 0; i < 3; i++) out->albedo[i] *= 1.0f - out->model_specular[i];
    memcpy(out->second_specular, m->second_specular, sizeof out->second_specular);
    out->second_alpha = m->second_alpha;
    memcpy(out->grazing, m->grazing, sizeof out->grazing);
    memcpy(out->eta, m->eta, sizeof out->eta);
    memcpy(out->k, m->k, sizeof out->k);
}

static void find_bsdf(const struct material *m, const struct material_uv *uv, bool inside,
                      struct bsdf *out)
{
    float color[4];
    memset(out, 0, sizeof *out);
    out->ior = 1.0f;
    if (m->unlit) return; /* black */
    material_base_color(m, uv, color);
    memcpy(out->albedo, color, sizeof out->albedo);
    memcpy(out->base_color, color, sizeof out->base_color);
    if (m->lambert)
        out->model = BSDF_LAMBERT;
    else if (m->model == MODEL_GLTF)
        set_gltf(m, uv, inside, out);
    else
        set_model(m, out);
}

static void material_init(struct material *m, const struct scene *blob,
                          const struct scene_material *s, const struct texture_decoding *decoding)
{
    memset(m, 0, sizeof *m);
    for (int i = 0; i < 4; i++) m->base_color[i] = unit_interval(s->base_color[i]);
    memcpy(m->emission, s->emission, sizeof m->emission);
    m->normal_scale = s->normal_scale;
    m->double_sided = s->flags & MATERIAL_DOUBLE_SIDED;
    m->unlit = s->flags & MATERIAL_UNLIT;
    m->emissive =
        m->unlit || s->emission[0] > 0.0f || s->emission[1] > 0.0f || s->emission[2] > 0.0f;
    m->model = s->model;
    m->colored = m->textured = s->flags & MATERIAL_COLORED;
    init_textures(m, blob, s, decoding);
    init_alpha(m, s);
    init_gltf(m, s);
    init_others(m, s);
    init_kind(m, s);
    m->culled = s->flags & MATERIAL_CULLED && !m->transmissive && !m->translucent && !m->blend;
    for (int i = 0; i < 3; i++)
        m->shown[i] = m->unlit ? 0.0f : m->lambert ? m->base_color[i] : 1.0f;
    if (m->textured) return;
    for (int inside = 0; inside < 2; inside++) find_bsdf(m, NULL, inside, &m->plain[inside]);
}

int material_table_create(const struct scene *blob, struct material_table **out)
{
    size_t count = (size_t)blob->count[SCENE_MATERIALS];
    struct material_table *table = malloc(sizeof *table + count * sizeof table->materials[0]);
    if (!table) return ERR_MEMORY;
    texture_decoding_init(&table->decoding);
    table->count = (uint32_t)count;
    for (size_t i = 0; i < count; i++)
        material_init(&table->materials[i], blob, &blob->materials[i], &table->decoding);
    *out = table;
    return 0;
}

void material_table_destroy(struct material_table **table)
{
    free(*table);
    *table = NULL;
}

float material_opacity(const struct material *m, const struct material_uv *uv)
{
    if (m->alpha_cutoff == 0.0f) return 1.0f;
    float color[4];
    material_base_color(m, uv, color);
    if (m->blend) return color[3];
    return color[3] >= m->alpha_cutoff ? 1.0f : 0.0f;
}

void material_emission(const struct material *m, const struct material_uv *uv, float out[3])
{
    float texel[4];
    if (m->unlit) {
        material_base_color(m, uv, texel);
        memcpy(out, texel, 3 * sizeof out[0]);
        return;
    }
    material_texel(&m->emission_texture, uv, texel);
    for (int i = 0; i < 3; i++) out[i] = m->emission[i] * texel[i];
}

void material_mean_emission(const struct material *m, float out[3])
{
    const struct texture *t = m->unlit ? &m->base_color_texture : &m->emission_texture;
    float mean[3] = {1.0f, 1.0f, 1.0f};
    if (t->texels) texture_mean(t, mean);
    for (int i = 0; i < 3; i++) out[i] = (m->unlit ? m->base_color[i] : m->emission[i]) * mean[i];
}

static void bend(const float texel[4], float scale, float out[3])
{
    out[0] = (2.0f * texel[0] - 1.0f) * scale;
    out[1] = (2.0f * texel[1] - 1.0f) * scale;
    out[2] = 2.0f * texel[2] - 1.0f;
}

static void map_normal(const struct texture *map, const struct material_uv *uv, float scale,
                       float out[3])
{
    float texel[4];
    out[0] = out[1] = 0.0f;
    out[2] = 1.0f;
    if (!map->texels) return;
    material_texel(map, uv, texel);
    bend(texel, scale, out);
}

void material_tangent_normal(const struct material *m, const struct material_uv *uv, float out[3])
{
    map_normal(&m->normal_texture, uv, m->normal_scale, out);
}

void material_coat_normal(const struct material *m, const struct material_uv *uv, float out[3])
{
    map_normal(&m->coat_normal_texture, uv, m->coat_normal_scale, out);
}

void material_bend(const struct material *m, const float texel[4], float out[3])
{
    bend(texel, m->normal_scale, out);
}

bool material_is_metallic_only(const struct material *m)
{
    return m->model == MODEL_GLTF && !m->lambert && !m->unlit && !m->transmissive &&
           !m->translucent;
}

void material_bsdf(const struct material *m, const struct material_uv *uv, bool inside,
                   struct bsdf *out)
{
    if (m->textured)
        find_bsdf(m, uv, inside, out);
    else
        *out = m->plain[inside];
}

void material_tangent_angle(const struct material *m, const struct material_uv *uv,
                            float direction[2])
{
    float x = 1.0f, y = 0.0f, texel[4];
    direction[0] = 1.0f;
    direction[1] = 0.0f;
    if (!m->anisotropic || m->model != MODEL_GLTF) return;
    if (m->anisotropy_texture.texels) {
        material_texel(&m->anisotropy_texture, uv, texel);
        x = 2.0f * texel[0] - 1.0f;
        y = 2.0f * texel[1] - 1.0f;
        float length = sqrtf(x * x + y * y);
        if (length < 1e-3f) return; /* no direction: any will do */
        x /= length;
        y /= length;
    }
    direction[0] = m->rotation[0] * x - m->rotation[1] * y;
    direction[1] = m->rotation[1] * x + m->rotation[0] * y;
}

void material_attenuation(const struct material *m, float distance, float transmittance[3])
{
    transmittance[0] = transmittance[1] = transmittance[2] = 1.0f;
    if (!(m->attenuation_distance > 0.0f)) return;
    float distances = distance / m->attenuation_distance;
    if (!(distances < DISTANCES_MAX)) distances = DISTANCES_MAX;
    for (int i = 0; i < 3; i++) transmittance[i] = elementary_exp(-m->absorption[i] * distances);
}
