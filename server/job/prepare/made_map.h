#pragma once
/* Environment maps that the server makes itself: no asset is behind them. */
#include "proto/scene/environment.h"
#include "server/store/objects.h"

/* Writes the blob of a map, whose texels are rows of three floats from the top, into the store,
 * unless it is there. ERR_LIMIT, ERR_NOT_FINITE, ERR_RANGE, ERR_MEMORY, ERR_IO, ... */
int made_map_place(const struct objects *objects, uint32_t width_px, uint32_t height_px,
                   const float *texels, struct environment_header *header, struct digest *blob,
                   struct fault *fault);
