#pragma once
/* Computes where the point at a pixel's centre was one frame before, and is one frame later, in
 * pixels. */
#include "proto/plan.h"
#include "server/image/image.h"
#include "server/reconstruct/compose/motion_mesh.h"
#include "server/reconstruct/patch/patch.h"

/* How an instance of the frame's scene moves. */
struct motion_part {
    bool moves[MOTION_SIDES];    /* else it stands, to the last bit */
    double to[MOTION_SIDES][12]; /* of what is rigid: 3 rows of 4, from the world now */
    struct motion_mesh *mesh;    /* owned; of what bends; NULL: it is rigid */
};

struct motion {
    struct plan_camera camera[MOTION_SIDES];
    uint32_t part_count;       /* instances */
    struct motion_part *parts; /* owned */
};

/* Creates a motion in which all stands and the cameras are zeros. ERR_MEMORY. */
int motion_create(uint32_t part_count, struct motion **out);
void motion_destroy(struct motion **motion);

/* Writes the channels motion.backward and motion.forward of `block`, as far as the image has them:
 * x to the right, y down, from the pixel's centre. Pixels without a surface count as infinitely far
 * away. The result is 0 where a side's camera does not look, and everywhere without a motion
 * (NULL). */
void motion_compose(const struct motion *motion, const struct plan *plan, const struct patch *patch,
                    struct rect block, struct image *image);
