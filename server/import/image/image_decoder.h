#pragma once
/* Decodes PNG, JPEG and WebP to RGBA8, rows from the top. The bytes tell the format, not a name. */
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"
#include "server/import/scene/warnings.h"

enum image_kind { IMAGE_PNG, IMAGE_JPEG, IMAGE_WEBP };

struct image_header {
    enum image_kind kind;
    uint32_t width_px, height_px;
};

/* Reads the size from the header and checks it against LIMIT_TEXTURE_SIDE_PX and
 * LIMIT_IMAGE_PIXELS, before anything is decoded. ERR_UNSUPPORTED for other formats, ERR_CORRUPT,
 * ERR_LIMIT. */
int image_measure(const uint8_t *data, size_t size_bytes, const char *place,
                  struct image_header *out, struct fault *fault);

/* Decodes into `rgba`, 4 * width * height bytes as measured. Greys become colours, missing alpha
 * is 255, 16 bits are rounded to 8; gamma and colour profiles are not applied (glTF 2.0, 3.9.2).
 * ERR_CORRUPT, ERR_MEMORY. */
int image_decode(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                 const char *place, uint8_t *rgba, struct warnings *warnings, struct fault *fault);

/* Decodes a PNG of one channel of 16 bits, such as a depth image. ERR_UNSUPPORTED for another file,
 * ERR_CORRUPT also for other samples. */
int image_decode_grey16(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                        const char *place, uint16_t *grey, struct fault *fault);

/* Decode one format each, for image_decode. */
int image_decode_png(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                     const char *place, uint8_t *rgba, struct fault *fault);
int image_decode_jpeg(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                      const char *place, uint8_t *rgba, struct warnings *warnings,
                      struct fault *fault);
int image_decode_webp(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                      const char *place, uint8_t *rgba, struct fault *fault);
int image_measure_webp(const uint8_t *data, size_t size_bytes, const char *place,
                       struct image_header *out, struct fault *fault);
int image_measure_jpeg(const uint8_t *data, size_t size_bytes, const char *place,
                       struct image_header *out, struct fault *fault);
