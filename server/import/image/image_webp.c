/* WebP (EXT_texture_webp). */
#include <webp/decode.h>

#include "server/import/image/image_decoder.h"

int image_measure_webp(const uint8_t *data, size_t size_bytes, const char *place,
                       struct image_header *out, struct fault *fault)
{
    WebPBitstreamFeatures features;
    const VP8StatusCode status = WebPGetFeatures(data, size_bytes, &features);
    if (status == VP8_STATUS_OUT_OF_MEMORY)
        return fault_set(fault, ERR_MEMORY, place, "no memory for the WebP image");
    if (status != VP8_STATUS_OK || features.width < 1 || features.height < 1)
        return fault_set(fault, ERR_CORRUPT, place, "the WebP image has no header");
    if (features.has_animation)
        return fault_set(fault, ERR_UNSUPPORTED, place, "the WebP image is an animation");
    *out = (struct image_header){IMAGE_WEBP, (uint32_t)features.width, (uint32_t)features.height};
    return 0;
}

int image_decode_webp(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                      const char *place, uint8_t *rgba, struct fault *fault)
{
    const size_t row_bytes = 4 * (size_t)header->width_px;
    if (WebPDecodeRGBAInto(data, size_bytes, rgba, row_bytes * header->height_px, (int)row_bytes))
        return 0;
    return fault_set(fault, ERR_CORRUPT, place, "the WebP image is damaged");
}
