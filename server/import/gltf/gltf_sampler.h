#pragma once
/* An animation's sampler: keys over time, and the value between them. */
#include "server/import/gltf/gltf.h"

/* Times of keys, kept because most samplers of an animation share them. */
struct gltf_key_times {
    uint32_t accessor; /* that they are of, while list is not NULL */
    uint32_t count;
    float *list; /* owned */
};

enum gltf_sampler_kind {
    GLTF_SAMPLED_NUMBERS,
    GLTF_SAMPLED_ROTATION /* a quaternion, which stays one of length 1 */
};

/* Reads the value at a time, *count numbers that the caller frees. With `targets` not 0 it has
 * that many elements of one number, else one element of the output's type. Before the first key
 * and behind the last it is theirs. The numbers are finite. ERR_RANGE, ERR_MISMATCH,
 * ERR_NOT_FINITE, ERR_TYPE, ... with the place. */
int gltf_sampler_read(struct gltf *g, const json_t *sampler, const char *place, double time_s,
                      enum gltf_sampler_kind kind, uint32_t targets, struct gltf_key_times *times,
                      double **values, uint32_t *count, struct fault *fault);
