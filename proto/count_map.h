#pragma once
/* Maps of the number of samples that each pixel of a tile gets. A map has a byte a pixel, row by
 * row. One or two maps follow each other, packed as a blosc buffer (LZ4), or as they are where that
 * is not smaller. */
#include "proto/bytes.h"
#include "proto/error.h"
#include "proto/limits.h"

#define COUNT_MAPS_MAX 2 /* of bounce rays, and of rays of glossy lobes */

/* The largest size of packed maps. */
#define COUNT_MAP_BYTES_MAX (COUNT_MAPS_MAX * LIMIT_TILE_SIDE_PX * LIMIT_TILE_SIDE_PX)

/* Appends `maps` packed maps of width_px x height_px pixels to w, whose `failed` tells of exhausted
 * memory. ERR_MEMORY, ERR_LIMIT for sides that no tile has and for other numbers of maps than 1 and
 * 2. */
int count_map_pack(struct bytes_writer *w, const uint8_t *counts, uint32_t maps, int32_t width_px,
                   int32_t height_px);

/* Unpacks into `counts`, which has room for maps x width_px x height_px. ERR_LIMIT as above,
 * ERR_CORRUPT for bytes that do not unpack to that many counts. */
int count_map_unpack(const void *data, size_t size_bytes, uint32_t maps, int32_t width_px,
                     int32_t height_px, uint8_t *counts);
