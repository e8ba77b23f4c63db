#pragma once
/* How many samples each pixel of a tile is to get: a byte a pixel, row by row, packed as a blosc
 * buffer (LZ4) or, where that is not smaller, as it is. */
#include "proto/bytes.h"
#include "proto/error.h"
#include "proto/limits.h"

/* The most that a packed map has. */
#define COUNT_MAP_BYTES_MAX (LIMIT_TILE_SIDE_PX * LIMIT_TILE_SIDE_PX)

/* Appends the packed counts of width_px x height_px pixels to w, whose `failed` tells of exhausted
 * memory. ERR_MEMORY, ERR_LIMIT for sides that no tile has. */
int count_map_pack(struct bytes_writer *w, const uint8_t *counts, int32_t width_px,
                   int32_t height_px);

/* Unpacks into `counts`, which has room for width_px x height_px. ERR_LIMIT for sides that no tile
 * has, ERR_CORRUPT for bytes that are not the packed counts of so many pixels. */
int count_map_unpack(const void *data, size_t size_bytes, int32_t width_px, int32_t height_px,
                     uint8_t *counts);
