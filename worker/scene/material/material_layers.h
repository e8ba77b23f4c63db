#pragma once
/* Sets what Khronos' extensions add to a glTF surface, or change in the light that passes it: coat,
 * sheen, film, diffuse transmission, dispersion. */
#include "worker/scene/material/material.h"

/* Reads a texture; ones where there is none. */
static inline void material_texel(const struct texture *t, const struct material_uv *uv,
                                  float out[4])
{
    if (t->texels)
        texture_sample(t, uv->set[t->uv_set][0], uv->set[t->uv_set][1], out);
    else
        out[0] = out[1] = out[2] = out[3] = 1.0f;
}

/* Sets them at a point of a glTF surface whose other fields are set. */
void material_layers_set(const struct material *m, const struct material_uv *uv, struct bsdf *out);
