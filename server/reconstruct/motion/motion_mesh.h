#pragma once
/* A mesh that bends. Tells where a point of its surface was before a frame, and is after it. */
#include <stdint.h>

#include "proto/error.h"

enum motion_side { MOTION_BACKWARD, MOTION_FORWARD, MOTION_SIDES };

struct motion_mesh;

/* Copies a mesh: `triangles` of three indexes of its vertices, which are floats of the world, now
 * and on both sides; NULL where it is not there then. ERR_MEMORY. */
int motion_mesh_create(const uint32_t *triangles, uint32_t triangle_count, uint32_t vertex_count,
                       const float *now, const float *const sides[MOTION_SIDES],
                       struct motion_mesh **out);
void motion_mesh_destroy(struct motion_mesh **mesh);

/* Finds the triangle nearest to a point of the surface, and where the same point of it is on a
 * side. `at` stays as it is where that is not known. */
void motion_mesh_follow(const struct motion_mesh *mesh, enum motion_side side, double at[3]);
