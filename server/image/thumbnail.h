#pragma once
/* Small pictures for lists: at most THUMBNAIL_SIDE_PX high and wide, in the shape of the picture.
 */
#include <stddef.h>
#include <stdint.h>

#include "server/image/image.h"

#define THUMBNAIL_SIDE_PX 160

/* Makes a small image of the beauty layer, for png_encode: means of at most 16 pixels each, so that
 * it costs the same for pictures of any size. The caller owns *out. ERR_NOT_FOUND without the
 * layer, ERR_MEMORY. */
int thumbnail_of_image(const struct image *image, struct image **out);

/* Makes a small PNG of an 8-bit RGB PNG in sRGB: means of all pixels, in linear light. The caller
 * frees *out. ERR_IO, ERR_CORRUPT, ERR_MEMORY. */
int thumbnail_of_png(const char *path, uint8_t **out, size_t *size_bytes);
