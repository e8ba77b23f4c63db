#include "proto/packing.h"

#include <blosc.h>
#include <string.h>

#define LEVEL 1 /* of either codec */

size_t packing_pack(enum packing packing, enum packing_shuffle shuffle, const void *data,
                    size_t size_bytes, uint32_t element_bytes, uint8_t *room)
{
    const char *codec = packing == PACKING_SMALL ? "zstd" : "lz4";
    const int kind = shuffle == PACKING_BITS ? BLOSC_BITSHUFFLE
                     : element_bytes > 1     ? BLOSC_SHUFFLE
                                             : BLOSC_NOSHUFFLE;
    const int packed = size_bytes > BLOSC_MIN_HEADER_LENGTH
                           ? blosc_compress_ctx(LEVEL, kind, element_bytes, size_bytes, data, room,
                                                size_bytes - 1, codec, 0, 1)
                           : 0;
    if (packed > 0) return (size_t)packed;
    if (size_bytes > 0) memcpy(room, data, size_bytes);
    return size_bytes;
}

bool packing_unpack(const uint8_t *packed, size_t packed_bytes, void *out, size_t size_bytes)
{
    size_t declared_bytes = 0;
    if (packed_bytes == size_bytes) {
        if (size_bytes > 0) memcpy(out, packed, size_bytes);
        return true;
    }
    if (packed_bytes < BLOSC_MIN_HEADER_LENGTH || packed_bytes > size_bytes) return false;
    if (blosc_cbuffer_validate(packed, packed_bytes, &declared_bytes) < 0) return false;
    if (declared_bytes != size_bytes) return false;
    const char *library = blosc_cbuffer_complib(packed);
    if (!library || (strcmp(library, "LZ4") != 0 && strcmp(library, "Zstd") != 0)) return false;
    return blosc_decompress_ctx(packed, out, size_bytes, 1) == (int)size_bytes;
}
