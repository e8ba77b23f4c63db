#pragma once
/* Parts of a glTF material that have files of their own. Each reads its objects of `json`, the
 * material at `place`, into *m. */
#include "server/import/gltf/gltf.h"

/* Reads Khronos' extensions of the surface beyond glTF's core, but for emission and unlit. */
int gltf_material_extensions_read(struct gltf *g, const json_t *json, const char *place,
                                  struct scene_material *m, struct fault *fault);

/* Reads extras.shearwater (proto/scene/scene.h lists its members), which replaces how the surface
 * scatters. Other extras are ignored. Every member is checked, unknown ones are refused. The base
 * colour must have been read. */
int gltf_material_extras_read(struct gltf *g, const json_t *json, const char *place,
                              struct scene_material *m, struct fault *fault);
