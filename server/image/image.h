#pragma once
/* A frame's output: named float channels, all of one size, allocated at once. */
#include <stdbool.h>

#include "proto/error.h"
#include "proto/plane.h"
#include "proto/tile.h"

#define IMAGE_CHANNELS 64

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

/* Channel names by layer: beauty R G B A; direct.R ...; indirect.R ...; emission.R ...; albedo.R
 * ...; normal.X .Y .Z; depth.Z; id.I; samples.N; visibility.V; slope_min.S; slope_max.S;
 * filter_width.W; error.R
 * ...; occlusion.O; diffuse_direct.R ...; diffuse_indirect.R .... `layers` are bits of
 * proto/job/job.h's enum layer, passed as a number. ERR_MEMORY, ERR_LIMIT, ERR_UNSUPPORTED for a
 * layer that is none here.
 */
int image_create(uint32_t layers, int32_t width_px, int32_t height_px, struct image **out);

/* For readers: any list of names. */
int image_create_named(const char *const *names, uint32_t count, int32_t width_px,
                       int32_t height_px, struct image **out);
void image_destroy(struct image **image);

/* The channel's plane, or NULL. */
const struct plane *image_plane(const struct image *image, const char *name);

/* The three channels that show a layer: "beauty" R G B, "direct" direct.R .G .B, "normal" X Y Z;
 * one channel three times for scalar layers. False when the image has none such. */
bool image_layer_planes(const struct image *image, const char *layer, const struct plane *rgb[3]);
