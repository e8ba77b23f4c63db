#pragma once
/* Where the virtual objects' scene stands in a sequence. */
#include "server/import/rgbd/depth_map.h"

/* Computes the way from the sequence's world to the scene, by to_scene or by what the pixel of
 * `place` shows. ERR_NOT_FOUND where too little depth is around it. */
int rgbd_place_find(const struct rgbd_document *d, struct files *files, struct affine *out,
                    struct warnings *warnings, struct fault *fault);
