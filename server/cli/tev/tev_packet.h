#pragma once
/* What tev, the image viewer (github.com/Tom94/tev), takes on its TCP port: packets of
 *
 *   u32 length of all of the packet, u8 kind, payload
 *
 * little-endian; texts end with a zero byte. Its README describes the framing; the order of the
 * payloads is that of its IpcPacket. */
#include <stddef.h>
#include <stdint.h>

#include "proto/tile.h"

enum tev_kind { TEV_CREATE_IMAGE = 4, TEV_UPDATE_IMAGE_V3 = 6 };

#define TEV_NAME_BYTES   128
#define TEV_CHANNELS_MAX 128

/* A packet that grows; all zero at first. */
struct tev_packet {
    uint8_t *data; /* owned */
    size_t size_bytes, held_bytes;
    int error; /* sticky: ERR_MEMORY, ERR_LIMIT */
};

void tev_packet_fini(struct tev_packet *p);

/* Makes the packet, whatever it held, create an image in tev, in place of one of that name. Channel
 * names are those of the EXR: R, G, B, A, direct.R ... Returns the packet's error. */
int tev_packet_create(struct tev_packet *p, const char *name, int32_t width_px, int32_t height_px,
                      const char *const *channels, uint32_t count);

/* Makes the packet update `count` channels of a rectangle. Channel c of pixel i is at
 * numbers[offset[c] + i * stride[c]], `held` numbers in all. */
int tev_packet_update(struct tev_packet *p, const char *name, struct rect rect,
                      const char *const *channels, uint32_t count, const int64_t *offset,
                      const int64_t *stride, const float *numbers, size_t held);
