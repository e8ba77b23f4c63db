#include "proto/count_map.h"

#include <blosc.h>
#include <stdlib.h>
#include <string.h>

static bool sides_fit(uint32_t maps, int32_t width_px, int32_t height_px)
{
    return maps >= 1 && maps <= COUNT_MAPS_MAX && width_px >= 1 && height_px >= 1 &&
           width_px <= LIMIT_TILE_SIDE_PX && height_px <= LIMIT_TILE_SIDE_PX;
}

int count_map_pack(struct bytes_writer *w, const uint8_t *counts, uint32_t maps, int32_t width_px,
                   int32_t height_px)
{
    if (!sides_fit(maps, width_px, height_px)) return ERR_LIMIT;
    const size_t area = maps * (size_t)width_px * (size_t)height_px;
    uint8_t *room = malloc(area);
    if (!room) return ERR_MEMORY;
    const int packed =
        area > BLOSC_MIN_HEADER_LENGTH
            ? blosc_compress_ctx(1, BLOSC_NOSHUFFLE, 1, area, counts, room, area - 1, "lz4", 0, 1)
            : 0;
    bytes_write_raw(w, packed > 0 ? room : counts, packed > 0 ? (size_t)packed : area);
    free(room);
    return w->failed ? ERR_MEMORY : 0;
}

int count_map_unpack(const void *data, size_t size_bytes, uint32_t maps, int32_t width_px,
                     int32_t height_px, uint8_t *counts)
{
    size_t unpacked_bytes = 0;
    if (!sides_fit(maps, width_px, height_px)) return ERR_LIMIT;
    const size_t area = maps * (size_t)width_px * (size_t)height_px;
    if (size_bytes == area) {
        memcpy(counts, data, area);
        return 0;
    }
    if (size_bytes > area || blosc_cbuffer_validate(data, size_bytes, &unpacked_bytes) != 0 ||
        unpacked_bytes != area)
        return ERR_CORRUPT;
    return blosc_decompress_ctx(data, counts, area, 1) == (int)area ? 0 : ERR_CORRUPT;
}
