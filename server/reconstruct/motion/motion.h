#pragma once
/* Computes where the point at a pixel's centre was one frame before, and is one frame later, in
 * pixels. */
#include "proto/plan.h"
#include "server/image/image.h"
#include "server/reconstruct/motion/motion_mesh.h"
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
    uint32_t holders;
};

/* Creates a motion in which all stands and the cameras are zeros, with one holder. ERR_MEMORY. */
int motion_create(uint32_t part_count, struct motion **out);

/* Holders are counted by one thread; NULL is fine. The last that drops a motion frees it. */
struct motion *motion_hold(struct motion *motion);
void motion_drop(struct motion **motion);

/* Returns whether two cameras see the same. */
bool motion_is_same_view(const struct plan_camera *a, const struct plan_camera *b);

/* Returns whether the frames beside one see the same as its camera. */
bool motion_keeps_view(const struct motion *motion, const struct plan_camera *now);

/* A point of a frame's scene, and where a frame sees it. */
struct motion_point {
    double x, y;  /* of the picture, in pixels */
    double at[3]; /* of the world; a direction where there is no surface */
    bool is_far;
    uint32_t id; /* 1 + the instance; 0: none */
};

/* Finds the point at the centre of a pixel, of which the patch has depth and id. */
void motion_show(const struct plan *plan, const struct patch *patch, int32_t x, int32_t y,
                 struct motion_point *out);

/* Moves a point from the frame of `plan` and `motion` to the one on a side. Without a motion (NULL)
 * nothing moves but the camera, which is that of `next`, the plan of that frame. Returns false
 * where that frame's camera does not look; x and y are then not set. What stands keeps them to the
 * last bit. */
bool motion_follow(const struct motion *motion, const struct plan *plan, const struct plan *next,
                   enum motion_side side, struct motion_point *point);

/* Writes the channels motion.backward and motion.forward of `block`, as far as the image has them:
 * x to the right, y down, from the pixel's centre. Pixels without a surface count as infinitely far
 * away. The result is 0 where a side's camera does not look, and everywhere without a motion
 * (NULL). */
void motion_compose(const struct motion *motion, const struct plan *plan, const struct patch *patch,
                    struct rect block, struct image *image);
