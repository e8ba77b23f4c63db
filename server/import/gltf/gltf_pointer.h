#pragma once
/* What a channel of an animation moves: a member of the document's JSON, by its pointer
 * (RFC 6901), such as "/nodes/3/rotation". */
#include "server/import/gltf/gltf_sampler.h"

struct gltf_pointer {
    json_t *holder;   /* borrowed; the object or array with the member; NULL: nothing is moved */
    char key[64];     /* of an object's member */
    size_t index;     /* of an array's element */
    uint32_t width;   /* numbers that the value must have; 0: any */
    uint32_t targets; /* of a mesh whose weights these are; 0: no weights */
    enum gltf_sampler_kind kind;
};

/* Finds a member that may be moved. Where there is none, the holder is NULL and a warning says so
 * at `place`. ERR_RANGE for a node that does not exist, ERR_SYNTAX for what is no pointer. */
int gltf_pointer_find(struct gltf *g, const char *text, const char *place, struct gltf_pointer *out,
                      struct fault *fault);

/* Replaces the member's value, by a number, a boolean or an array as the member is one. */
int gltf_pointer_set(const struct gltf_pointer *pointer, const double *values, uint32_t count,
                     const char *place, struct fault *fault);
