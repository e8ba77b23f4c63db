#include <turbojpeg.h>

#include "server/import/image/image_decoder.h"

int image_measure_jpeg(const uint8_t *data, size_t size_bytes, const char *place,
                       struct image_header *out, struct fault *fault)
{
    tjhandle tj = tjInitDecompress();
    if (tj == NULL) return fault_set(fault, ERR_MEMORY, place, "no memory for a JPEG decoder");
    int width = 0, height = 0, subsampling, colorspace;
    int rc = tjDecompressHeader3(tj, data, size_bytes, &width, &height, &subsampling, &colorspace);
    if (rc != 0 || width <= 0 || height <= 0)
        rc = fault_set(fault, ERR_CORRUPT, place, "the JPEG image cannot be decoded: %.200s",
                       tjGetErrorStr2(tj));
    else
        *out = (struct image_header){IMAGE_JPEG, (uint32_t)width, (uint32_t)height};
    tjDestroy(tj);
    return rc;
}

int image_decode_jpeg(const uint8_t *data, size_t size_bytes, const struct image_header *header,
                      const char *place, uint8_t *rgba, struct warnings *warnings,
                      struct fault *fault)
{
    tjhandle tj = tjInitDecompress();
    if (tj == NULL) return fault_set(fault, ERR_MEMORY, place, "no memory for a JPEG decoder");
    int rc =
        tjDecompress2(tj, data, size_bytes, rgba, (int)header->width_px, 0, (int)header->height_px,
                      TJPF_RGBA, TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS);
    if (rc != 0 && tjGetErrorCode(tj) == TJERR_WARNING) {
        warnings_add(warnings, place, "the JPEG image is damaged: %.200s", tjGetErrorStr2(tj));
        rc = 0;
    } else if (rc != 0) {
        rc = fault_set(fault, ERR_CORRUPT, place, "the JPEG image cannot be decoded: %.200s",
                       tjGetErrorStr2(tj));
    }
    tjDestroy(tj);
    return rc;
}
