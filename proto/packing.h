#pragma once
/* Numbers of one size as a blosc buffer: shuffled, then compressed. What does not get smaller stays
 * as it is. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum packing {
    PACKING_QUICK, /* for what stays on the machine: LZ4 */
    PACKING_SMALL, /* for what crosses a network: filters (plane_filter.h) and Zstandard; two to
                      four times the time for two thirds to three quarters of the bytes */
};

enum packing_shuffle {
    PACKING_BYTES, /* first bytes of all numbers, then second ones; of single bytes: as they are */
    PACKING_BITS,  /* the same with bits */
};

/* Packs size_bytes of numbers of element_bytes (1, 2, 4) into room for as much. Returns the packed
 * size; size_bytes where they were copied. */
size_t packing_pack(enum packing packing, enum packing_shuffle shuffle, const void *data,
                    size_t size_bytes, uint32_t element_bytes, uint8_t *room);

/* Unpacks a buffer. False: packed_bytes do not become size_bytes. */
bool packing_unpack(const uint8_t *packed, size_t packed_bytes, void *out, size_t size_bytes);
