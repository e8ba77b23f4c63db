#pragma once
/* A frame's output: named float channels of one size, in one allocation. */
#include <stdbool.h>

#include "proto/error.h"
#include "proto/plane.h"
#include "proto/tile.h"

#define IMAGE_CHANNELS 96

struct image_channel {
    char name[32]; /* "R", "direct.R", "depth.Z": as in the EXR */
    struct plane plane;
};

struct image {
    int32_t width_px, height_px;
    uint32_t channel_count;
    struct image_channel channels[IMAGE_CHANNELS];
    float *data; /* owned; channel_count * width * height, zeroed */
};

/* Creates the channels of layers: R G B A of beauty; .R .G .B of direct, indirect, emission,
 * albedo, error, diffuse_direct and diffuse_indirect, such as direct.R; normal.X .Y .Z; depth.Z;
 * id.I; samples.N; visibility.V; slope_min.S; slope_max.S; filter_width.W; occlusion.O;
 * motion.backward.X .Y; motion.forward.X .Y; composite.R .G .B; catcher.R .G .B; overlay.R .G .B
 * .A; what compositors take for colours, and ids and shares of six ranks, of CryptoObject and
 * CryptoMaterial: CryptoObject.R .G .B, CryptoObject00.R .G .B .A to 02. `layers` are bits of
 * proto/job/job.h's enum layer, passed as a number. ERR_MEMORY, ERR_LIMIT, ERR_UNSUPPORTED for an
 * unknown layer. */
int image_create(uint32_t layers, int32_t width_px, int32_t height_px, struct image **out);

/* Creates channels of any names, for readers. */
int image_create_named(const char *const *names, uint32_t count, int32_t width_px,
                       int32_t height_px, struct image **out);
void image_destroy(struct image **image);

/* Returns the channel's plane, or NULL. */
const struct plane *image_plane(const struct image *image, const char *name);

/* Finds the three channels that show a layer: R G B for "beauty", direct.R .G .B for "direct", X Y
 * Z for "normal". A scalar layer gives its channel three times. Returns false if the image lacks
 * it. */
bool image_layer_planes(const struct image *image, const char *layer, const struct plane *rgb[3]);

/* Returns the layer that people look at first: the composite, if there is one, or beauty. */
const char *image_main_layer(const struct image *image);

/* Returns whether a layer is light, which people see through a view (view_transform.h): beauty and
 * its parts, and layers of files of others. Albedo and errors are colours of another kind, all else
 * are numbers. */
bool image_layer_is_light(const char *layer);
