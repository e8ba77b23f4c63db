#pragma once
/* A camera for scenes that have none: a three-quarter view of all of it. */
#include "proto/scene/scene.h"

/* Places a perspective camera so that a box fills an image of this shape (width over height) but
 * for a margin. It looks from the front (+z), right and above. */
void camera_fit(const float lowest[3], const float highest[3], double aspect,
                struct scene_camera *camera);
