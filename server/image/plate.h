#pragma once
/* A photograph that pictures are composed with: linear light, as large as the picture. Frames share
 * it. */
#include "proto/error.h"
#include "server/image/image.h"

struct plate;

enum plate_scaling { PLATE_COVER, PLATE_STRETCH };

/* Makes a plate of interleaved RGB texels, rows from the top. Where its size is not the picture's,
 * it is averaged over areas where it shrinks, and interpolated where it grows; PLATE_COVER keeps
 * its shape and cuts what is beside. One reference. ERR_MEMORY. */
int plate_create(const float *texels, int32_t texels_across, int32_t texels_down, int32_t width_px,
                 int32_t height_px, enum plate_scaling scaling, struct plate **out);

/* Makes a smaller copy of a plate, which shows all that it does. ERR_MEMORY. */
int plate_shrink(const struct plate *plate, int32_t width_px, int32_t height_px,
                 struct plate **out);

/* Take and release a reference; NULL is ignored; drop nulls the pointer. Any thread. */
struct plate *plate_hold(struct plate *plate);
void plate_drop(struct plate **plate);

/* Returns its channels R, G, B. */
const struct image *plate_image(const struct plate *plate);
