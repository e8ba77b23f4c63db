#pragma once
/* Chooses where a scene's coordinates are counted from. Floats of a scene far from its origin are
 * coarse, so such a scene is moved to its middle; struct scene_info keeps by how much. */
#include <stdbool.h>

#include "server/import/scene/builder.h"
#include "server/import/scene/mesh.h"

/* Chooses an origin for what lies in a box, in steps that floats of the box's size have. Returns
 * false, and zeros, for a box near the origin, beyond LIMIT_COORDINATE or of no size. */
bool origin_choose(const double lowest[3], const double highest[3], double origin[3]);

/* Moves a mesh whose own vertices are far from their origin, by -origin; zeros where they are near.
 * Warns of vertices so far that their floats' steps show. */
void origin_move_mesh(struct mesh *mesh, const char *place, struct warnings *warnings,
                      double origin[3]);

/* Moves a scene of meshes that all stand untransformed, as those of OBJ do. */
void origin_move_scene(struct builder *b, const char *place);
