#pragma once
/* Typed reading of glTF's JSON. Every fault names its place as glTF people write it:
 * "meshes[3].primitives[0].indices". A member that is absent leaves its out-parameter untouched. */
#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "proto/error.h"

typedef char gltf_place[LIMIT_POINTER_BYTES];

/* Formats a place; cut when too long. */
void gltf_place_set(gltf_place out, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* *out is NULL when absent. ERR_TYPE when it is there and something else. */
int gltf_object(const json_t *of, const char *place, const char *key, const json_t **out,
                struct fault *fault);
int gltf_array(const json_t *of, const char *place, const char *key, const json_t **out,
               struct fault *fault);
int gltf_text(const json_t *of, const char *place, const char *key, const char **out,
              struct fault *fault);

/* Element `i` of a top-level array, an object: root["meshes"][3]; writes its place, "meshes[3]". */
int gltf_item(const json_t *root, const char *array, size_t i, const json_t **out, gltf_place place,
              struct fault *fault);

/* How many elements a top-level array has; 0 when absent or of another type. */
size_t gltf_count(const json_t *root, const char *array);

int gltf_flag(const json_t *of, const char *place, const char *key, bool *inout,
              struct fault *fault);

/* A number in [lowest, highest]. ERR_TYPE, ERR_RANGE. */
int gltf_number(const json_t *of, const char *place, const char *key, double lowest, double highest,
                double *inout, struct fault *fault);
int gltf_integer(const json_t *of, const char *place, const char *key, uint64_t highest,
                 uint64_t *inout, struct fault *fault);

/* An index below `count`; SCENE_NONE when absent. */
int gltf_index(const json_t *of, const char *place, const char *key, size_t count, uint32_t *out,
               struct fault *fault);

/* Exactly `n` numbers in [lowest, highest]. *present (may be NULL) tells whether they were there.
 */
int gltf_vector(const json_t *of, const char *place, const char *key, size_t n, double lowest,
                double highest, double *inout, bool *present, struct fault *fault);

/* The same for what is kept as float. */
int gltf_float(const json_t *of, const char *place, const char *key, double lowest, double highest,
               float *inout, struct fault *fault);
int gltf_floats(const json_t *of, const char *place, const char *key, size_t n, double lowest,
                double highest, float *inout, struct fault *fault);

/* of["extensions"][name]; NULL when absent. Writes its place. */
int gltf_extension(const json_t *of, const char *place, const char *name, const json_t **out,
                   gltf_place out_place, struct fault *fault);
