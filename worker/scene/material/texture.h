#pragma once
/* A texture as shading reads it has texels in the blob, wrap modes, a filter and a decoding.
 *
 * (0, 0) is the top left corner of the image; u runs right and v down, as in glTF. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/scene/scene.h"

/* Tables from bytes to linear values, one for sRGB-encoded channels and one for plain ones. */
struct texture_decoding {
    float srgb[256];
    float linear[256];
};

void texture_decoding_init(struct texture_decoding *d);

struct texture {
    const uint8_t *texels; /* RGBA8, rows from the top; NULL: no texture */
    const float *decode;   /* of the colour channels; alpha is always plain */
    const float *decode_alpha;
    int32_t width_px, height_px;
    uint32_t wrap_u, wrap_v; /* enum texture_wrap */
    uint32_t nearest;
    uint32_t uv_set;
    float transform[6]; /* as scene_texture_ref */
};

/* Makes a material's reference readable. ref->texture may be SCENE_NONE. `blob` and `decoding` must
 * outlive *out. */
void texture_init(struct texture *out, const struct scene *blob,
                  const struct scene_texture_ref *ref, const struct texture_decoding *decoding);

/* Coordinates are cut here. Beyond it they have hardly any fraction left, and conversions to int
 * stay defined. */
#define TEXTURE_COORDINATE_MAX 1e6f

static inline void texture_decode(const struct texture *t, size_t texel, float out[4])
{
    const uint8_t *from = t->texels + 4 * texel;
    out[0] = t->decode[from[0]];
    out[1] = t->decode[from[1]];
    out[2] = t->decode[from[2]];
    out[3] = t->decode_alpha[from[3]];
}

/* Interpolates between four texels, the upper ones first. `across` leads to the right ones and
 * `down` to the lower ones. */
static inline void texture_blend(const struct texture *t, const size_t at[4], float across,
                                 float down, float out[4])
{
    float a[4], b[4], c[4], d[4];
    texture_decode(t, at[0], a);
    texture_decode(t, at[1], b);
    texture_decode(t, at[2], c);
    texture_decode(t, at[3], d);
    for (int i = 0; i < 4; i++) {
        float upper = a[i] + across * (b[i] - a[i]), lower = c[i] + across * (d[i] - c[i]);
        out[i] = upper + down * (lower - upper);
    }
}

/* Computes linear RGBA at the mesh's (u, v), transformed, wrapped and filtered. t->texels must not
 * be NULL. */
void texture_sample(const struct texture *t, float u, float v, float out[4]);

/* Returns the least alpha of all texels, in [0, 1]. */
float texture_min_alpha(const struct texture *t);

/* Computes the mean linear colour of all texels, whatever part of them UVs use. */
void texture_mean(const struct texture *t, float out[3]);
