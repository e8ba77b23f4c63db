#pragma once
/* The surfaces that a frame's camera sees, as a mesh: a square of two triangles for each pixel with
 * a depth. Squares of one surface share corners; where depth jumps they do not, but the corners of
 * both stand on one ray, so that the camera sees no gap. Jumps run along pixels' sides, evened out
 * into straight lines: how much of a pixel is in front is then what samples find. */
#include "server/import/rgbd/depth_map.h"
#include "server/import/scene/mesh.h"

/* Makes the mesh in the camera's coordinates: x right, y down, z ahead. `white` is the colour of
 * what reflects 0.8 of the light; colours of vertices are albedo. The triangles from
 * *first_shining on are of pixels that shine themselves: they are too bright to be lit. ERR_MEMORY.
 */
int depth_mesh_make(const struct depth_map *map, const struct rgbd_document *d,
                    const float white[3], struct mesh *out, uint32_t *first_shining,
                    struct fault *fault);
