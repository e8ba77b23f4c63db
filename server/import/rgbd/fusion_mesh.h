#pragma once
/* The surface where a volume's distances are zero, as a mesh: a vertex in each cell of eight voxels
 * that it passes, at the mean of where it meets the cell's edges, and a square for each edge
 * (surface nets: Gibson 1998, "Constrained elastic surface nets"). It breaks where a voxel is not
 * known, and at jumps: where distances change by more than a surface between two voxels could. */
#include "server/import/rgbd/fusion.h"
#include "server/import/scene/mesh.h"

/* Makes the mesh in metres from the volume's origin, with fronts towards what was free. Colours of
 * vertices are albedo. The triangles from *first_shining on shine themselves. The mesh is empty
 * where there is no surface. ERR_MEMORY. */
int fusion_mesh_make(const struct fusion *f, struct mesh *out, uint32_t *first_shining,
                     struct fault *fault);
