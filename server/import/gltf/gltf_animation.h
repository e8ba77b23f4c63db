#pragma once
/* Animations (glTF 2.0, section 3.11; KHR_animation_pointer). Each channel's value at the chosen
 * time is written into the document's JSON, in place of the resting value. So all that is read
 * afterwards, such as nodes, weights, cameras, lights and materials, stands as it does then. */
#include "server/import/gltf/gltf.h"

/* Finds what the chosen animations move, without moving it, into g->moving. ERR_NOT_FOUND for a
 * name that no animation has; for errors of the file ERR_RANGE, ERR_MISMATCH, ERR_NOT_FINITE,
 * ERR_TYPE, ... with the place. */
int gltf_animations_find(struct gltf *g, const struct scene_choice *choice, struct fault *fault);
void gltf_moving_fini(struct gltf_moving *moving);

/* Moves the document to a time. Errors as above. */
int gltf_animations_apply(struct gltf *g, const struct scene_choice *choice, double time_s,
                          struct fault *fault);
