#include "server/import/image/photograph.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/image/image_decoder.h"

bool photograph_is_known(const struct file_view *file)
{
    const uint8_t *data = file->data;
    const size_t n = file->size_bytes;
    return (n >= 8 && memcmp(data, "\x89PNG\r\n\x1a\n", 8) == 0) ||
           (n >= 3 && memcmp(data, "\xff\xd8\xff", 3) == 0) ||
           (n >= 12 && memcmp(data, "RIFF", 4) == 0 && memcmp(data + 8, "WEBP", 4) == 0);
}

/* IEC 61966-2-1. */
static void fill_table(float linear[256])
{
    for (int i = 0; i < 256; i++) {
        const double v = i / 255.0;
        linear[i] = (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
}

static void make_linear(const uint8_t *rgba, struct panorama *p)
{
    float linear[256];
    const size_t count = (size_t)p->width_px * p->height_px;
    fill_table(linear);
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++) p->texels[3 * i + c] = linear[rgba[4 * i + c]];
}

int photograph_read(const struct file_view *file, const char *name, struct panorama *out,
                    struct warnings *warnings, struct fault *fault)
{
    struct image_header header;
    int rc = image_measure(file->data, file->size_bytes, name, &header, fault);
    if (rc == 0) rc = panorama_create(out, header.width_px, header.height_px, name, fault);
    if (rc != 0) return rc;
    uint8_t *rgba = malloc((size_t)header.width_px * header.height_px * 4);
    if (rgba == NULL)
        rc = fault_set(fault, ERR_MEMORY, name, "no memory for its pixels");
    else
        rc = image_decode(file->data, file->size_bytes, &header, name, rgba, warnings, fault);
    if (rc == 0 && rgba != NULL)
        make_linear(rgba, out);
    else
        panorama_destroy(out);
    free(rgba);
    return rc;
}
