#pragma once
/* The layers diffuse_direct and diffuse_indirect: the light of pixel centres before albedo and
 * anti-aliasing. Beside paths that bring other lobes, centres without a diffuse one have none, and
 * what paths have put there stays. */
#include "server/image/image.h"
#include "server/reconstruct/compose/resolve.h"

/* Write the block's part of the layer, where the image has it. */
void compose_diffuse_direct(const struct resolver *resolver, struct rect block,
                            struct image *image);
void compose_diffuse_indirect(const struct resolver *resolver, struct rect block,
                              struct image *image);
