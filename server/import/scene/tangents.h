#pragma once
/* Makes tangent spaces for normal maps where the file has none. */
#include "server/import/scene/mesh.h"

/* Sets mesh->tangents from positions, normals and the UV set `set`, all of which must be there.
 * As MikkTSpace does, each corner adds the direction of growing u, projected to the vertex's
 * tangent plane and weighted by the corner's angle. Vertices between mirrored halves of a texture
 * are split. It must follow mesh_check. ERR_MEMORY, ERR_LIMIT. */
int mesh_make_tangents(struct mesh *mesh, int set, const char *place, struct fault *fault);
