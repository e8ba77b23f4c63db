#pragma once
/* Shades the lanes that met one mesh with textures, all at once. The results are those of hit.c. */
#include "worker/trace/hit/hit.h"

struct hit_kernels;

/* Normal map, albedo of Lambert surfaces and emission of the lanes in *on, as hit_shade_textured.
 */
void textured_shade(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                    const struct lanes_mask *on, const struct RTCHit16 *hit, struct surface *out);

/* Albedos of the lanes in *on, as material_bsdf; false, and nothing is done, for materials that
 * need more than base colour and metalness for that. */
bool textured_albedo(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                     const struct lanes_mask *on, const struct RTCHit16 *hit, struct surface *out);
