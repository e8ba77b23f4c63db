#pragma once
/* Finds how the scene of a frame moves, from the frame before and to the frame after it. */
#include "proto/scene/scene.h"
#include "server/reconstruct/motion/motion.h"

/* Compares a frame's scene with those of both sides, which stand on the same base, if on any.
 * `cameras` are the plans'. Parts that a side lacks stand. ERR_MEMORY. */
int frame_motion_create(const struct scene *now, const struct scene *const sides[MOTION_SIDES],
                        const struct plan_camera cameras[MOTION_SIDES], struct motion **out);
