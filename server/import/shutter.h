#pragma once
/* What moves while the shutter is open: the poses of a frame at the steps of proto/shutter.h. */
#include "server/import/gltf/gltf.h"

/* A frame that is to have them. */
struct shutter_frame {
    struct gltf *g;
    const struct scene_choice *choice;
    double time_s;
    const struct digest *base;
    struct builder *builder; /* finished */
};

/* Adds movers and their steps, and poses of cameras, if something moves. What shines stands: it is
 * sampled where it is in the middle. Where things appear or vanish meanwhile all stands. */
int shutter_add(const struct shutter_frame *frame, struct fault *fault);
