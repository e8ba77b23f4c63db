#include "server/image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "proto/runtime/pages.h"

#define LAYER_CHANNELS 15

/* Colours to look at, and as Cryptomatte has it, two ids with their shares in each four channels.
 */
#define MATTE_CHANNELS(name)                                                                       \
    {                                                                                              \
        name ".R", name ".G", name ".B", name "00.R", name "00.G", name "00.B", name "00.A",       \
            name "01.R", name "01.G", name "01.B", name "01.A", name "02.R", name "02.G",          \
            name "02.B", name "02.A"                                                               \
    }

/* Layer b is bit 1 << b of proto/job/job.h's enum layer, which this room does not include, since it
 * has nothing to do with jobs. A unit test compares the two. */
static const struct layer_channels {
    const char *name;
    const char *channels[LAYER_CHANNELS];
    bool is_light;
} layers[] = {
    {"beauty", {"R", "G", "B", "A"}, true},
    {"direct", {"direct.R", "direct.G", "direct.B"}, true},
    {"indirect", {"indirect.R", "indirect.G", "indirect.B"}, true},
    {"albedo", {"albedo.R", "albedo.G", "albedo.B"}, false},
    {"normal", {"normal.X", "normal.Y", "normal.Z"}, false},
    {"depth", {"depth.Z"}, false},
    {"samples", {"samples.N"}, false},
    {"visibility", {"visibility.V"}, false},
    {"slope_min", {"slope_min.S"}, false},
    {"slope_max", {"slope_max.S"}, false},
    {"emission", {"emission.R", "emission.G", "emission.B"}, true},
    {"id", {"id.I"}, false},
    {"filter_width", {"filter_width.W"}, false},
    {"error", {"error.R", "error.G", "error.B"}, false},
    {"occlusion", {"occlusion.O"}, false},
    {"diffuse_direct", {"diffuse_direct.R", "diffuse_direct.G", "diffuse_direct.B"}, true},
    {"diffuse_indirect", {"diffuse_indirect.R", "diffuse_indirect.G", "diffuse_indirect.B"}, true},
    {"motion.backward", {"motion.backward.X", "motion.backward.Y"}, false},
    {"motion.forward", {"motion.forward.X", "motion.forward.Y"}, false},
    {"composite", {"composite.R", "composite.G", "composite.B"}, true},
    {"catcher", {"catcher.R", "catcher.G", "catcher.B"}, false},
    {"overlay", {"overlay.R", "overlay.G", "overlay.B", "overlay.A"}, true},
    {"CryptoObject", MATTE_CHANNELS("CryptoObject"), false},
    {"CryptoMaterial", MATTE_CHANNELS("CryptoMaterial"), false},
    {"backplate", {"backplate.R", "backplate.G", "backplate.B"}, true},
};
#define LAYER_COUNT (sizeof layers / sizeof layers[0])

static void lay_planes(struct image *image)
{
    size_t pixels = (size_t)image->width_px * (size_t)image->height_px;
    for (uint32_t c = 0; c < image->channel_count; c++) {
        image->channels[c].plane = (struct plane){.data = image->data + c * pixels,
                                                  .width_px = image->width_px,
                                                  .height_px = image->height_px,
                                                  .stride = image->width_px};
    }
}

int image_create_named(const char *const *names, uint32_t count, int32_t width_px,
                       int32_t height_px, struct image **out)
{
    *out = NULL;
    if (count == 0 || count > IMAGE_CHANNELS) return ERR_LIMIT;
    if (width_px < 1 || width_px > LIMIT_IMAGE_SIDE_PX) return ERR_LIMIT;
    if (height_px < 1 || height_px > LIMIT_IMAGE_SIDE_PX) return ERR_LIMIT;
    if ((int64_t)width_px * height_px > LIMIT_IMAGE_PIXELS) return ERR_LIMIT;
    struct image *image = calloc(1, sizeof *image);
    if (!image) return ERR_MEMORY;
    image->width_px = width_px;
    image->height_px = height_px;
    image->channel_count = count;
    int error = 0;
    for (uint32_t c = 0; c < count; c++) {
        if (strlen(names[c]) >= sizeof image->channels[c].name)
            error = ERR_LIMIT;
        else
            memcpy(image->channels[c].name, names[c], strlen(names[c]) + 1);
    }
    if (!error) {
        const size_t numbers = (size_t)width_px * (size_t)height_px * count;
        image->data = calloc(numbers, sizeof *image->data);
        if (!image->data) error = ERR_MEMORY;
        if (image->data) pages_prefer_huge(image->data, numbers * sizeof *image->data);
    }
    if (error) {
        image_destroy(&image);
        return error;
    }
    lay_planes(image);
    *out = image;
    return 0;
}

int image_create(uint32_t wanted, int32_t width_px, int32_t height_px, struct image **out)
{
    const char *names[IMAGE_CHANNELS];
    uint32_t count = 0;
    *out = NULL;
    if (wanted >> LAYER_COUNT) return ERR_UNSUPPORTED;
    for (uint32_t b = 0; b < LAYER_COUNT; b++) {
        if (!(wanted >> b & 1u)) continue;
        for (int c = 0; c < LAYER_CHANNELS && layers[b].channels[c]; c++)
            names[count++] = layers[b].channels[c];
    }
    return image_create_named(names, count, width_px, height_px, out);
}

void image_destroy(struct image **image)
{
    if (!*image) return;
    free((*image)->data);
    free(*image);
    *image = NULL;
}

const struct plane *image_plane(const struct image *image, const char *name)
{
    for (uint32_t c = 0; c < image->channel_count; c++) {
        if (!strcmp(image->channels[c].name, name)) return &image->channels[c].plane;
    }
    return NULL;
}

/* Layers that are not in the table come from files of others: LAYER.R, .G, .B. */
static bool foreign_planes(const struct image *image, const char *layer, const struct plane *rgb[3])
{
    static const char letters[] = "RGB";
    for (int c = 0; c < 3; c++) {
        char name[sizeof image->channels[0].name];
        if (snprintf(name, sizeof name, "%s.%c", layer, letters[c]) >= (int)sizeof name)
            return false;
        rgb[c] = image_plane(image, name);
        if (!rgb[c]) return false;
    }
    return true;
}

bool image_layer_planes(const struct image *image, const char *layer, const struct plane *rgb[3])
{
    for (uint32_t b = 0; b < LAYER_COUNT; b++) {
        if (strcmp(layers[b].name, layer) != 0) continue;
        int last = 0; /* one that lacks channels shows its last again */
        while (last < 2 && layers[b].channels[last + 1]) last++;
        for (int c = 0; c < 3; c++) {
            rgb[c] = image_plane(image, layers[b].channels[c < last ? c : last]);
            if (!rgb[c]) return false;
        }
        return true;
    }
    return foreign_planes(image, layer, rgb);
}

const char *image_main_layer(const struct image *image)
{
    return image_plane(image, "composite.R") ? "composite" : "beauty";
}

bool image_layer_is_light(const char *layer)
{
    for (uint32_t b = 0; b < LAYER_COUNT; b++)
        if (!strcmp(layers[b].name, layer)) return layers[b].is_light;
    return true;
}
