#pragma once
/* Does what rgbd_import.h does with one model of the place (rgbd_fuse.h) for all frames. */
#include "server/import/rgbd/rgbd_light.h"

struct rgbd_model {
    struct rgbd_document document;
    struct affine place;      /* from the sequence's world to the scene's */
    int32_t width, height;    /* of its images */
    uint64_t first, end;      /* its meshes in the builder */
    bool all_shine;           /* the first of them does, too */
    struct rgbd_light *light; /* owned; the same in all frames */
};

/* Appends the model to a builder, in coordinates of a scene without an origin, and does not place
 * it: to a base, whose frames place it, or to a scene. Faults have pointers that begin with /rgbd.
 */
int rgbd_model_open(struct rgbd_model *m, struct files *files, const struct scene_choice *choice,
                    struct builder *b, struct fault *fault);

/* Frees what the model holds, in both cases. */
void rgbd_model_close(struct rgbd_model *m);

/* Adds the frame at a time to the scene that has the model, or to one that stands on a base that
 * has it and has the other objects already. ERR_NOT_FOUND after the last frame. */
int rgbd_model_add_frame(const struct rgbd_model *m, const struct scene_choice *choice,
                         double time_s, struct builder *b, struct fault *fault);
