#pragma once
/* 8-bit PNG for people: exposure, then the sRGB curve. */
#include "server/image/image.h"

/* Encodes a layer (as image_layer_planes names them) into memory that the caller frees. Radiance
 * layers are multiplied by 2^exposure and clipped; albedo likewise; normals are shown as
 * (n + 1) / 2; depth, id, samples are scaled to their largest value. ERR_NOT_FOUND for a layer that
 * is not there. */
int png_encode(const struct image *image, const char *layer, float exposure, uint8_t **out,
               size_t *size_bytes);
