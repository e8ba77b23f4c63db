/* OpenEXR files, through the reader that the command line compares pictures with. */
#include <string.h>

#include "server/image/exr.h"
#include "server/import/image/panorama.h"

bool panorama_is_exr(const struct file_view *file)
{
    static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};
    return file->size_bytes >= sizeof magic && memcmp(file->data, magic, sizeof magic) == 0;
}

/* Finds the planes of red, green and blue. */
static int find_planes(const struct image *image, const char *name, const struct plane *rgb[3],
                       struct fault *fault)
{
    static const char *const names[3] = {"R", "G", "B"};
    const struct plane *grey = image_plane(image, "Y");
    if (image_plane(image, "RY") != NULL || image_plane(image, "BY") != NULL) {
        fault_set(fault, ERR_UNSUPPORTED, name,
                  "luminance with colour differences (RY, BY) is not read");
        return ERR_UNSUPPORTED;
    }
    bool any = false;
    for (int c = 0; c < 3; c++) {
        rgb[c] = image_plane(image, names[c]);
        any |= rgb[c] != NULL;
    }
    if (!any && grey != NULL) rgb[0] = rgb[1] = rgb[2] = grey;
    for (int c = 0; c < 3; c++) {
        if (rgb[c] != NULL) continue;
        fault_set(fault, ERR_MISSING, name, "the channel %s is missing", names[c]);
        return ERR_MISSING;
    }
    return 0;
}

static void interleave(const struct plane *const rgb[3], struct panorama *out)
{
    float *to = out->texels;
    for (int32_t y = 0; y < (int32_t)out->height_px; y++)
        for (int32_t x = 0; x < (int32_t)out->width_px; x++)
            for (int c = 0; c < 3; c++) *to++ = *plane_at(rgb[c], x, y);
}

int panorama_read_exr(const struct file_view *file, const char *name, struct panorama *out,
                      struct fault *fault)
{
    static const char *const channels[] = {"R", "G", "B", "Y", "RY", "BY"};
    const struct exr_selection selection = {.channels = channels,
                                            .channel_count = sizeof channels / sizeof *channels,
                                            .pixels_max = LIMIT_ENVIRONMENT_PIXELS,
                                            .whole = true};
    const struct plane *rgb[3];
    struct image *image = NULL;
    *out = (struct panorama){0};
    int rc = exr_read_memory(file->data, file->size_bytes, name, &selection, &image, fault);
    if (rc != 0) return rc;
    rc = find_planes(image, name, rgb, fault);
    if (rc == 0) rc = panorama_create(out, image->width_px, image->height_px, name, fault);
    if (rc == 0) interleave(rgb, out);
    image_destroy(&image);
    return rc;
}
