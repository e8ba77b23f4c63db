#include "tests/property/dress.h"

#include <math.h>
#include <string.h>

enum { TEXELS = CASE_TEXELS * CASE_TEXELS, BRIGHT_ONE_IN = 6 };
#define LEAN 0.4f /* of normals, over the half sides' directions */

static uint8_t any(struct random *r)
{
    return (uint8_t)(random_bits(r) >> 56);
}

static void draw_texel(struct random *r, enum body_dress dress, uint8_t out[4])
{
    for (int k = 0; k < 4; k++) out[k] = any(r);
    if (dress == DRESS_NORMAL) out[2] = (uint8_t)(160 + out[2] / 4);
    if (dress == DRESS_GLOW && random_bits(r) % BRIGHT_ONE_IN) out[0] = out[1] = out[2] = 0;
    if (dress != DRESS_MASK && dress != DRESS_BLEND) out[3] = 255;
}

/* Of a normal map u and v are what swaps, too. */
static void turn_texel(enum body_dress dress, const uint8_t in[4], uint8_t out[4])
{
    memcpy(out, in, 4);
    if (dress == DRESS_NORMAL) out[0] = in[1], out[1] = in[0];
}

static void draw_texels(const struct case_body *b, uint8_t out[TEXELS][4])
{
    struct random r = {b->texels};
    for (int y = 0; y < CASE_TEXELS; y++)
        for (int x = 0; x <= y; x++) {
            uint8_t *own = out[y * CASE_TEXELS + x];
            draw_texel(&r, b->dress, own);
            if (x == y && b->dress == DRESS_NORMAL) own[0] = own[1];
            if (x < y) turn_texel(b->dress, own, out[x * CASE_TEXELS + y]);
        }
}

/* Some go over a quad more than once, some have hard edges. */
static struct scene_texture_ref add_texture(struct scene_fixture *f, const struct case_body *b,
                                            bool colors)
{
    uint8_t texels[TEXELS][4];
    const float scale = b->texels % 3 == 0 ? 2.5f : 1.0f, from = b->texels % 5 == 0 ? 0.3f : 0.0f;
    draw_texels(b, texels);
    const uint32_t texture = fixture_texture(f, CASE_TEXELS, CASE_TEXELS, texels[0],
                                             colors && b->texels % 2 ? IMAGE_IS_SRGB : 0);
    f->textures[texture].filter = b->texels % 4 == 0 ? FILTER_NEAREST : FILTER_LINEAR;
    f->textures[texture].wrap_u = f->textures[texture].wrap_v = b->texels % 3;
    return (struct scene_texture_ref){.texture = texture,
                                      .transform = {scale, 0, from, 0, scale, from}};
}

void dress_material(struct scene_fixture *f, uint32_t material, const struct case_body *b,
                    double gain)
{
    struct scene_material *m = &f->materials[material];
    switch (b->dress) {
    case DRESS_COLOR:
    case DRESS_MASK:
    case DRESS_BLEND:
    case DRESS_UNLIT:
        m->base_color_texture = add_texture(f, b, true);
        m->alpha_cutoff = 0.5f;
        if (b->dress == DRESS_MASK) m->alpha_mode = ALPHA_MASK;
        if (b->dress == DRESS_BLEND) m->alpha_mode = ALPHA_BLEND;
        if (b->dress == DRESS_UNLIT) m->flags |= MATERIAL_UNLIT;
        break;
    case DRESS_NORMAL:
        m->normal_texture = add_texture(f, b, false);
        break;
    case DRESS_ROUGH:
        m->metallic_roughness_texture = add_texture(f, b, false);
        m->metallic = 1;
        break;
    case DRESS_GLOW:
        for (int k = 0; k < 3; k++) m->emission[k] = (float)(4 * gain * b->albedo[k]);
        m->emission_texture = add_texture(f, b, true);
        break;
    default:
        break;
    }
}

bool dress_has_normals(const struct case_body *b)
{
    return (b->smooth || b->dress == DRESS_NORMAL) && b->shape <= BODY_ROOM;
}

static bool to_unit(float v[3])
{
    const float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] = length > 0 ? v[k] / length : 0;
    return length > 0;
}

static void set_vertex(struct scene_fixture *f, uint32_t vertex, const float normal[3],
                       const float tangent[3])
{
    memcpy(f->normals + (size_t)3 * vertex, normal, 3 * sizeof normal[0]);
    memcpy(f->tangents + (size_t)4 * vertex, tangent, 3 * sizeof tangent[0]);
    f->tangents[4 * vertex + 3] = 1;
}

void dress_quad(struct scene_fixture *f, const struct case_body *b, const float u[3],
                const float v[3])
{
    float a[3] = {u[0], u[1], u[2]}, c[3] = {v[0], v[1], v[2]};
    /* Of quads without area whatever: nobody sees them. */
    if (!to_unit(a)) memcpy(a, (float[]){1, 0, 0}, sizeof a);
    if (!to_unit(c)) memcpy(c, (float[]){0, 1, 0}, sizeof c);
    for (uint32_t i = 0; i < 4; i++) {
        const float right = i == 1 || i == 2 ? LEAN : -LEAN, down = i >= 2 ? LEAN : -LEAN;
        float n[3];
        for (int k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            n[k] = a[l] * c[m] - a[m] * c[l];
            if (b->smooth) n[k] += right * a[k] + down * c[k];
        }
        if (!to_unit(n)) memcpy(n, (float[]){0, 0, 1}, sizeof n);
        set_vertex(f, f->vertex_count - 4 + i, n, a);
    }
}
