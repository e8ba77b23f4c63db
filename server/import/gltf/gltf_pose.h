#pragma once
/* Poses meshes: morph targets are added by their weights, then joints move the skin (glTF 2.0,
 * sections 3.7.2.2 and 3.7.3.3). */
#include "server/import/gltf/gltf_primitive.h"

/* Finds whether a pose moves a primitive's vertices. `poser` is a node with a skin or weights of
 * its own, or SCENE_NONE. */
int gltf_pose_moves(struct gltf *g, uint32_t mesh, uint32_t primitive, uint32_t poser, bool *moves,
                    struct fault *fault);

/* Moves the vertices of *mesh, which has all of the file's vertices and may hold any numbers. Those
 * of a skin end in the world. */
int gltf_pose_apply(struct gltf *g, const struct gltf_geometry *geometry, const char *place,
                    struct mesh *mesh, struct fault *fault);
