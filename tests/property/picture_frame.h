#pragma once
/* A frame of the coordinator with one worker, both in this process: what is leased is traced,
 * packed as on the wire and sent, round after round, until all pixels are as they will stay. */
#include "proto/plan.h"
#include "proto/scene/environment.h"
#include "proto/scene/scene.h"
#include "server/image/image.h"
#include "server/job/frame/statistics.h"

struct picture_frame_options {
    uint32_t layers;
    int32_t block_px;
    bool backwards; /* results come last tile first */
};

/* The map's header is NULL where there is none. The image is the caller's. Ends the program when
 * the frame fails. */
void picture_frame_render(const struct plan *plan, const struct scene *scene,
                          const struct environment_blob *map,
                          const struct picture_frame_options *options, struct image **image,
                          struct statistics *statistics);
