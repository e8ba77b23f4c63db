#pragma once
/* Reads accessors: typed arrays in buffers, with strides, normalised integers and sparse parts. */
#include "server/import/gltf/gltf.h"

/* Reads vectors as floats; normalised integers become [0, 1] or [-1, 1]. `components` is what the
 * type must have. The caller frees *out. ERR_TYPE, ERR_RANGE, ERR_TRUNCATED, ERR_LIMIT,
 * ERR_MEMORY. */
int gltf_read_floats(struct gltf *g, uint32_t accessor, uint32_t components, uint32_t *count,
                     float **out, struct fault *fault);

/* Returns how many components the type of an accessor has. */
int gltf_accessor_components(struct gltf *g, uint32_t accessor, uint32_t *out, struct fault *fault);

/* Returns what integers of an accessor are multiplied by: 1 unless they are normalised. */
int gltf_accessor_scale(struct gltf *g, uint32_t accessor, float *out, struct fault *fault);

/* Reads unsigned integers. The caller frees *out. */
int gltf_read_indices(struct gltf *g, uint32_t accessor, uint32_t *count, uint32_t **out,
                      struct fault *fault);
