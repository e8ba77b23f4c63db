#pragma once
/* Begins and ends a material's record, for every reader. */
#include <stdbool.h>

#include "proto/scene/scene.h"
#include "server/import/scene/warnings.h"

/* Sets what an absent material means (glTF 2.0, section 3.9.6; defaults of the KHR extensions). */
void surface_init(struct scene_material *m);

/* Returns whether the material refers to the tangents of its meshes, whatever its normal maps. */
bool surface_is_anisotropic(const struct scene_material *m);

/* Lists the textures of a material. */
enum { SURFACE_TEXTURES = 17 };
void surface_textures(struct scene_material *m, struct scene_texture_ref *out[SURFACE_TEXTURES]);

/* Scales base_color and model_specular where a channel of their sum exceeds 1, so that the surface
 * reflects no more than it receives; warns. For models with a diffuse and a specular lobe. */
void surface_conserve(struct scene_material *m, const char *place, struct warnings *warnings);
