#pragma once
/* A texture as shading reads it: texels in the blob, wrap modes, filter, decoding.
 *
 * (0, 0) is the top left corner of the image; u runs right, v down, as in glTF. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/scene.h"

/* Byte to linear value: one table for sRGB-encoded channels, one for plain ones. */
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

/* A material's reference made readable; ref->texture may be SCENE_NONE. `blob` and `decoding` must
 * outlive *out. */
void texture_init(struct texture *out, const struct scene *blob,
                  const struct scene_texture_ref *ref, const struct texture_decoding *decoding);

/* Linear RGBA at the mesh's (u, v), transformed, wrapped and filtered. t->texels must not be NULL.
 */
void texture_sample(const struct texture *t, float u, float v, float out[4]);

/* The least alpha of all texels, in [0, 1]. */
float texture_least_alpha(const struct texture *t);

/* The mean colour of all texels, linear, wherever UVs may lead. */
void texture_mean(const struct texture *t, float out[3]);
