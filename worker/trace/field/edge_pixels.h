#pragma once
/* Pixels at edges: those of which one of the eight centres around shows another surface
 * (mixed_finder.h). They get more paths than others do, since no other pixel tells how much of them
 * each surface covers. The choice does not depend on what paths bring, which would bias their
 * mean. */
#include "worker/trace/field/mixed_finder.h"

/* Finds a tile's pixels at edges, as finder->edge, in passes after the first. Centres are traced
 * anew for it. All is borrowed; `lone` begins anew. ERR_MEMORY. */
int edge_pixels_find(const struct path_context *c, struct rect tile, struct lone_finder *lone,
                     struct mixed_finder *finder);
