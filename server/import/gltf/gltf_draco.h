#pragma once
/* KHR_draco_mesh_compression: a primitive whose vertices and triangles are one compressed stream.
 */
#include "server/import/gltf/gltf.h"
#include "server/import/scene/mesh.h"

/* Returns whether a primitive is compressed. */
bool gltf_draco_is(const json_t *primitive);

/* Decodes a primitive into g->draco. ERR_CORRUPT, ERR_MEMORY, ERR_LIMIT, ... with its place. */
int gltf_draco_begin(struct gltf *g, const json_t *primitive, const char *place,
                     struct fault *fault);
void gltf_draco_end(struct gltf *g);

/* Makes its triangles. The arrays become *out's. */
int gltf_draco_triangles(struct gltf *g, struct mesh *out, struct fault *fault);

/* Reads an attribute of the primitive that is being loaded as gltf_read_floats does: from the
 * stream if it holds it, else from its accessor. `components` 0: as many as there are, in
 * *components. */
int gltf_vertex_floats(struct gltf *g, const char *key, uint32_t accessor, uint32_t *components,
                       uint32_t *count, float **out, struct fault *fault);
