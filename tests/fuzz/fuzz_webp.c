/* WebP images of textures: whatever the bytes, a fault that says why, or as many pixels as the
 * header promised; the address sanitizer watches. */
// sources: server/import/image/image_*.c server/import/scene/warnings.c
// libs: -lpng -lturbojpeg -lwebp
#include <stdlib.h>
#include <string.h>

#include "server/import/image/image_decoder.h"

/* Fuzzing is for streams, not for filling memory. */
#define PIXELS_MAX 1000000u

static void decode(const uint8_t *data, size_t size_bytes, const struct image_header *header)
{
    static struct warnings warnings;
    struct fault fault = {0};
    const size_t pixels = (size_t)header->width_px * header->height_px;
    if (pixels == 0) abort();
    if (pixels > PIXELS_MAX) return;
    uint8_t *rgba = malloc(4 * pixels);
    if (!rgba) abort();
    memset(&warnings, 0, sizeof warnings);
    const int error = image_decode(data, size_bytes, header, "images[0]", rgba, &warnings, &fault);
    if (error && (fault.code != error || fault.detail[0] == '\0')) abort();
    free(rgba);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct image_header header;
    struct fault fault = {0};
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    if (!exact) abort();
    if (size_bytes > 0) memcpy(exact, data, size_bytes);
    const int error = image_measure(exact, size_bytes, "images[0]", &header, &fault);
    if (error && (fault.code != error || fault.detail[0] == '\0')) abort();
    if (!error) decode(exact, size_bytes, &header);
    free(exact);
    return 0;
}
