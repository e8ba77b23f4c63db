#include "worker/scene/material.h"

#include <stdlib.h>
#include <string.h>

/* Blended surfaces are there where more than half of their light is theirs: this version has no
 * partial transparency. */
#define BLEND_CUTOFF 0.5f

static float unit_interval(float v)
{
    return v < 0.0f ? 0.0f : v > 1.0f ? 1.0f : v;
}

static float cutoff(const struct scene_material *s, const struct material *m)
{
    if (s->alpha_mode == ALPHA_OPAQUE) return 0.0f;
    float at = s->alpha_mode == ALPHA_MASK ? s->alpha_cutoff : BLEND_CUTOFF;
    const struct texture *t = &m->base_color_texture;
    float least = m->base_color[3] * (t->texels ? texture_least_alpha(t) : 1.0f);
    return least >= at ? 0.0f : at; /* nowhere transparent: no test */
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
    texture_init(&m->base_color_texture, blob, &s->base_color_texture, decoding);
    texture_init(&m->normal_texture, blob, &s->normal_texture, decoding);
    texture_init(&m->emission_texture, blob, &s->emission_texture, decoding);
    m->textured =
        m->base_color_texture.texels || m->normal_texture.texels || m->emission_texture.texels;
    m->alpha_cutoff = cutoff(s, m);
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

static void sample_at(const struct texture *t, const struct material_uv *uv, float out[4])
{
    texture_sample(t, uv->set[t->uv_set][0], uv->set[t->uv_set][1], out);
}

void material_base_color(const struct material *m, const struct material_uv *uv, float out[4])
{
    memcpy(out, m->base_color, 4 * sizeof out[0]);
    if (!m->base_color_texture.texels) return;
    float texel[4];
    sample_at(&m->base_color_texture, uv, texel);
    for (int i = 0; i < 4; i++) out[i] *= texel[i];
}

void material_emission(const struct material *m, const struct material_uv *uv, float out[3])
{
    float texel[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    if (m->unlit) {
        material_base_color(m, uv, texel);
        memcpy(out, texel, 3 * sizeof out[0]);
        return;
    }
    if (m->emission_texture.texels) sample_at(&m->emission_texture, uv, texel);
    for (int i = 0; i < 3; i++) out[i] = m->emission[i] * texel[i];
}

void material_tangent_normal(const struct material *m, const struct material_uv *uv, float out[3])
{
    float texel[4];
    sample_at(&m->normal_texture, uv, texel);
    out[0] = (2.0f * texel[0] - 1.0f) * m->normal_scale;
    out[1] = (2.0f * texel[1] - 1.0f) * m->normal_scale;
    out[2] = 2.0f * texel[2] - 1.0f;
}
