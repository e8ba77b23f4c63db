#include "server/import/image/image_decoder.h"

#include <inttypes.h>
#include <stdbool.h>
#include <string.h>

static const uint8_t png_magic[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

static uint32_t read_big_endian(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

static bool is_webp(const uint8_t *data, size_t size_bytes)
{
    return size_bytes >= 12 && memcmp(data, "RIFF", 4) == 0 && memcmp(data + 8, "WEBP", 4) == 0;
}

static const char *foreign_format(const uint8_t *data, size_t size_bytes)
{
    if (size_bytes >= 7 && memcmp(data, "\xabKTX 20", 7) == 0) return "KTX2";
    if (size_bytes >= 4 && memcmp(data, "DDS ", 4) == 0) return "DDS";
    if (size_bytes >= 4 && memcmp(data, "GIF8", 4) == 0) return "GIF";
    if (size_bytes >= 2 && memcmp(data, "BM", 2) == 0) return "BMP";
    return NULL;
}

static int refuse_format(const uint8_t *data, size_t size_bytes, const char *place,
                         struct fault *fault)
{
    const char *name = foreign_format(data, size_bytes);
    if (size_bytes == 0) return fault_set(fault, ERR_TRUNCATED, place, "the image is empty");
    if (name != NULL)
        return fault_set(fault, ERR_UNSUPPORTED, place,
                         "it is a %s image; PNG, JPEG and WebP are read", name);
    return fault_set(fault, ERR_UNSUPPORTED, place, "it is no PNG, JPEG or WebP image");
}

int image_measure(const uint8_t *data, size_t size_bytes, const char *place,
                  struct image_header *out, struct fault *fault)
{
    if (size_bytes >= 8 && memcmp(data, png_magic, sizeof png_magic) == 0) {
        if (size_bytes < 33 || memcmp(data + 12, "IHDR", 4) != 0)
            return fault_set(fault, ERR_CORRUPT, place, "the PNG image has no header");
        *out = (struct image_header){IMAGE_PNG, read_big_endian(data + 16),
                                     read_big_endian(data + 20)};
    } else if (size_bytes >= 3 && memcmp(data, "\xff\xd8\xff", 3) == 0) {
        int rc = image_measure_jpeg(data, size_bytes, place, out, fault);
        if (rc != 0) return rc;
    } else if (is_webp(data, size_bytes)) {
        int rc = image_measure_webp(data, size_bytes, place, out, fault);
        if (rc != 0) return rc;
    } else {
        return refuse_format(data, size_bytes, place, fault);
    }
    uint32_t w = out->width_px, h = out->height_px;
    if (w == 0 || h == 0)
        return fault_set(fault, ERR_CORRUPT, place, "it has %" PRIu32 " x %" PRIu32 " pixels", w,
                         h);
    if (w > LIMIT_TEXTURE_SIDE_PX || h > LIMIT_TEXTURE_SIDE_PX ||
        (uint64_t)w * h > LIMIT_IMAGE_PIXELS)
        return fault_set(fault, ERR_LIMIT, place,
                         "%" PRIu32 " x %" PRIu32 " pixels are too many; a side has at most %u", w,
                         h, LIMIT_TEXTURE_SIDE_PX);
    return 0;
}

int image_decode(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                 const char *place, uint8_t *rgba, struct warnings *warnings, struct fault *fault)
{
    if (header->kind == IMAGE_PNG)
        return image_decode_png(data, size_bytes, header, place, rgba, fault);
    if (header->kind == IMAGE_WEBP)
        return image_decode_webp(data, size_bytes, header, place, rgba, fault);
    return image_decode_jpeg(data, size_bytes, header, place, rgba, warnings, fault);
}
