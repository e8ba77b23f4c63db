#pragma once
/* Tangent spaces for normal maps where the file brings none. */
#include "server/import/scene/mesh.h"

/* Sets mesh->tangents from positions, normals and the UV set `set`, all of which must be there.
 * Per corner the direction of growing u, projected to the vertex's tangent plane and weighted by
 * the corner's angle, as MikkTSpace does it; vertices between mirrored halves of a texture are
 * split. Call after mesh_check. ERR_MEMORY, ERR_LIMIT. */
int mesh_make_tangents(struct mesh *mesh, int set, const char *place, struct fault *fault);
