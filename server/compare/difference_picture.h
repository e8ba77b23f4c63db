#pragma once
/* Draws where one image is brighter or darker than another. */
#include "server/image/image.h"

/* Rows of the legend under the picture. */
#define DIFFERENCE_LEGEND_PX 16

/* Creates an image R, G, B for png_encode. It shows the signed relative difference d = (x - r) /
 * sqrt(r^2 + 0.01 mean(r)^2), averaged over the layer's channels; white where it is 0, blue below,
 * red above, darkest from -range and +range on, yellow where it is not finite. Every pixel becomes
 * zoom x zoom. Below stands a legend from -range (left) to +range (right), with ticks at quarters.
 *
 * `layer` is named as in image_layer_planes. The caller owns *out. ERR_NOT_FOUND, ERR_MISMATCH,
 * ERR_LIMIT, ERR_MEMORY; ERR_RANGE for range <= 0 or zoom < 1. */
int difference_picture(const struct image *reference, const struct image *test, const char *layer,
                       double range, int32_t zoom, struct image **out, struct fault *fault);
