#pragma once
/* Layers of ids for compositors (proto/scene/matte.h). */
#include "proto/tile.h"
#include "server/image/image.h"
#include "server/reconstruct/patch/patch.h"

/* Writes the channels of CryptoObject and CryptoMaterial: ids as floats of the same bits, each
 * followed by its share of the pixel, and colours to look at that are told by the ids. */
void mattes_compose(const struct patch *patch, struct rect block, struct image *image);
