#pragma once
/* Makes a smaller image out of a larger one, so that pictures are compared where their noise is
 * small. The image is cut, then averaged over squares. */
#include "server/image/image.h"

/* Cuts `crop` out of the image and averages every channel over box x box pixels, except for
 * standard errors (channels "error.R" and so on) of independent pixels: those of a mean of n are
 * sqrt(sum se^2) / n. Columns and rows on the right and at the bottom that fill no square are
 * dropped; a value that is not finite makes its whole square so. The caller owns *out.
 *
 * ERR_RANGE for a crop that is empty or outside the image, or a box that is below 1 or larger than
 * the crop; ERR_MEMORY. */
int image_reduce(const struct image *image, struct rect crop, int32_t box_px, struct image **out,
                 struct fault *fault);

/* Returns all of the image, for `crop`. */
struct rect image_rect(const struct image *image);
