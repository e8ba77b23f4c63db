#pragma once
/* One mesh between a scene file and the builder. It has arrays of its own and one material.
 *
 * Optional arrays run parallel to the positions; NULL where the mesh lacks them. */
#include "server/import/scene/builder.h"
#include "server/import/scene/transform.h"

struct mesh {
    uint32_t vertex_count, triangle_count;
    float *positions;    /* float[3]; all arrays are owned */
    float *normals;      /* float[3] */
    float *tangents;     /* float[4], w the bitangent's sign */
    float *uvs[2];       /* float[2] */
    float *colors;       /* float[4] */
    uint32_t *triangles; /* uint32_t[3] */
};

void mesh_fini(struct mesh *mesh);

/* Makes a copy that the caller owns; on failure *out is empty. ERR_MEMORY. */
int mesh_copy(const struct mesh *mesh, struct mesh *out, struct fault *fault);

/* Checks every number and index, makes normals and tangents unit vectors and brings colours into
 * [0, 1]; vectors of length zero are replaced, with a warning. ERR_NOT_FINITE, ERR_LIMIT, ERR_RANGE
 * with the vertex at fault. */
int mesh_check(struct mesh *mesh, const char *place, struct warnings *warnings,
               struct fault *fault);

/* Rebuilds all vertex arrays so that new vertex v is a copy of old vertex source[v]; the triangles
 * stay as they are. ERR_MEMORY. */
int mesh_gather(struct mesh *mesh, const uint32_t *source, uint32_t count, struct fault *fault);

/* Drops vertices that no triangle uses; keeps the order. Indexes must be valid. ERR_MEMORY. */
int mesh_compact(struct mesh *mesh, struct fault *fault);

/* Gives every triangle vertices of its own, with its own normal; afterwards vertex 3t + k is corner
 * k of triangle t. ERR_MEMORY, ERR_LIMIT. */
int mesh_flatten(struct mesh *mesh, const char *place, struct fault *fault);

/* Turns the winding of all triangles over. */
void mesh_turn_over(struct mesh *mesh);

/* Applies a transform to positions, normals and tangents. When it mirrors, the winding is turned
 * over, so that the front side stays the front side (glTF 2.0, section 3.7.4). */
int mesh_transform(struct mesh *mesh, const struct affine *to_world, const char *place,
                   struct fault *fault);

/* Appends the arrays to the builder. *out gets the ranges and the flags of what the mesh has;
 * material and name are the caller's. Stores no scene_mesh record. */
int mesh_append(const struct mesh *mesh, struct builder *b, struct scene_mesh *out,
                struct fault *fault);

/* Computes the triangle's normal by winding. Its length is twice the area. */
void mesh_triangle_normal(const float *positions, const uint32_t triangle[3], double out[3]);

/* Computes a unit direction at right angles to a unit normal. */
void mesh_any_tangent(const float normal[3], double out[3]);
