#pragma once
/* Reads members of glTF's JSON by type. Every fault names its place in glTF's usual form, such as
 * "meshes[3].primitives[0].indices". A member that is absent leaves its out-parameter untouched. */
#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "proto/error.h"

typedef char gltf_place[LIMIT_POINTER_BYTES];

/* Formats a place, and cuts it if it is too long. */
void gltf_place_set(gltf_place out, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Read a member of a type. *out is NULL when it is absent. ERR_TYPE when it has another type. */
int gltf_object(const json_t *of, const char *place, const char *key, const json_t **out,
                struct fault *fault);
int gltf_array(const json_t *of, const char *place, const char *key, const json_t **out,
               struct fault *fault);
int gltf_text(const json_t *of, const char *place, const char *key, const char **out,
              struct fault *fault);

/* Returns element `i` of a top-level array, an object such as root["meshes"][3], and its place,
 * "meshes[3]". */
int gltf_item(const json_t *root, const char *array, size_t i, const json_t **out, gltf_place place,
              struct fault *fault);

/* Returns how many elements a top-level array has; 0 when it is absent or of another type. */
size_t gltf_count(const json_t *root, const char *array);

int gltf_flag(const json_t *of, const char *place, const char *key, bool *inout,
              struct fault *fault);

/* Reads a number in [lowest, highest]. ERR_TYPE, ERR_RANGE. */
int gltf_number(const json_t *of, const char *place, const char *key, double lowest, double highest,
                double *inout, struct fault *fault);
int gltf_integer(const json_t *of, const char *place, const char *key, uint64_t highest,
                 uint64_t *inout, struct fault *fault);

/* Reads an index below `count`; SCENE_NONE when absent. */
int gltf_index(const json_t *of, const char *place, const char *key, size_t count, uint32_t *out,
               struct fault *fault);

/* Reads exactly `n` numbers in [lowest, highest]. *present (may be NULL) says whether they were
 * there. */
int gltf_vector(const json_t *of, const char *place, const char *key, size_t n, double lowest,
                double highest, double *inout, bool *present, struct fault *fault);

/* Do the same for numbers that are stored as float. */
int gltf_float(const json_t *of, const char *place, const char *key, double lowest, double highest,
               float *inout, struct fault *fault);
int gltf_floats(const json_t *of, const char *place, const char *key, size_t n, double lowest,
                double highest, float *inout, struct fault *fault);

/* Returns of["extensions"][name] and its place; NULL when absent. */
int gltf_extension(const json_t *of, const char *place, const char *name, const json_t **out,
                   gltf_place out_place, struct fault *fault);
