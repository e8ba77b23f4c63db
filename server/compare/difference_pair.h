#pragma once
/* Measures the error of an image x beside two independent references a and b, without their noise.
 * The mean of (x - a)(x - b) is the mean square error of x beside what both converge to, since the
 * noise of a and that of b are not correlated. */
#include "server/image/image.h"

struct difference_pair {
    double psnr_db;   /* -10 log10 mean (g(x) - g(a)) (g(x) - g(b)); g: sRGB, clipped to [0, 1] */
    double rmse01;    /* sqrt mean (c(x) - c(a)) (c(x) - c(b)); c: clipped to [0, 1] */
    double relmse999; /* mean (x - a) (x - b) / (r^2 + 0.01), r = (a + b) / 2, over all but the
                       * thousandth of the pixels where it is largest; it may be below 0 */
};

/* Computes the error. Means are over pixels and the layer's channels. The first two figures are NAN
 * where their mean is not above 0: x is as near to the references as their noise can show.
 *
 * `layer` as in image_layer_planes. ERR_MISMATCH for other sizes, ERR_NOT_FOUND when an image lacks
 * the layer, ERR_NOT_FINITE with *fault naming the pixel, ERR_MEMORY. */
int difference_pair(const struct image *first, const struct image *second, const struct image *test,
                    const char *layer, struct difference_pair *out, struct fault *fault);

/* Computes the mean of both references, in the channels that both have, and from standard errors
 * (channels "error.R" and so on) that of the mean. The caller owns *out. ERR_MISMATCH, ERR_MEMORY;
 * ERR_NOT_FOUND when they share no channel. */
int difference_pair_mean(const struct image *first, const struct image *second, struct image **out,
                         struct fault *fault);
