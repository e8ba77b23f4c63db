#pragma once
/* Shades the lanes that met one mesh with textures, all at once. The results are those of hit.c. */
#include "worker/trace/hit/hit.h"

struct hit_kernels;

/* Sets the normal map's normal, albedo of Lambert surfaces and emission of the lanes in *on, as
 * hit_shade_textured does. */
void textured_shade(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                    const struct lanes_mask *on, const struct RTCHit16 *hit, struct surface *out);

/* Sets the albedos of the lanes in *on, as material_bsdf does. Returns false, and does nothing, for
 * materials whose albedo needs more than base colour and metalness. */
bool textured_albedo(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                     const struct lanes_mask *on, const struct RTCHit16 *hit, struct surface *out);
