#pragma once
/* libdraco from C: a compressed mesh, decoded. No exception leaves these functions. */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct draco_shim;

enum draco_shim_status { DRACO_SHIM_OK, DRACO_SHIM_DAMAGED, DRACO_SHIM_NO_MEMORY };

/* Decodes a triangle mesh. On success the caller owns *out. */
enum draco_shim_status draco_shim_decode(const uint8_t *data, size_t size_bytes,
                                         struct draco_shim **out);
void draco_shim_destroy(struct draco_shim **mesh);

uint32_t draco_shim_vertices(const struct draco_shim *mesh);
uint32_t draco_shim_triangles(const struct draco_shim *mesh);

/* Writes three indices a triangle, each below the count of vertices. Returns 0 if one is not. */
int draco_shim_indices(const struct draco_shim *mesh, uint32_t *out);

/* Returns how many components the attribute of a unique id has; 0: there is none. */
uint32_t draco_shim_components(const struct draco_shim *mesh, uint32_t id);

/* Writes `components` numbers a vertex; integers are not normalised. Returns 0 when it cannot. */
int draco_shim_floats(const struct draco_shim *mesh, uint32_t id, uint32_t components, float *out);

#ifdef __cplusplus
}
#endif
