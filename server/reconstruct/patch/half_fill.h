#pragma once
/* Fills pixels without rays of their own in light fields at half resolution: each takes the light
 * of the nodes beside it that show its surface (proto/half_field.h). Filters then treat all pixels
 * alike. What a pixel takes is a weighted mean, and constant light stays constant.
 *
 * The arrays of bounce rays and of glossy lobes change in place, wherever the patch has them.
 * Pixels on the patch's border lack nodes, unless the image ends there: nothing else may read
 * these. */
#include "server/reconstruct/patch/patch.h"

/* How far a pixel looks for nodes. */
#define HALF_FILL_REACH_PX 1

/* Does nothing unless the plan has fields at half resolution. */
void half_fill(const struct plan *plan, struct patch *patch);
