#pragma once
/* Skins: vertices follow joints, which are nodes. */
#include "server/import/gltf/gltf.h"
#include "server/import/scene/mesh.h"

/* Moves a mesh's vertices into the world, each by the blend of its joints' matrices. `primitive`
 * names the joints and weights of vertices. Triangles are turned over where most vertices are
 * mirrored. ERR_MISMATCH, ERR_RANGE, ERR_MISSING with the place. */
int gltf_skin_apply(struct gltf *g, uint32_t skin, const json_t *primitive, const char *place,
                    struct mesh *mesh, struct fault *fault);
