#pragma once
/* Computes how far one image is from another: the figures of docs/accuracy.md, on linear values. */
#include <stdbool.h>

#include "server/image/image.h"

struct difference {
    double rmse;   /* over pixels and the layer's channels */
    double relmse; /* mean((x-r)^2 / (r^2 + 0.01 mean(r)^2)) */
    double bias;   /* mean(x - r) */
    double p999;   /* 99.9th percentile of |x - r| */
    double max;    /* largest |x - r| */
    double mean_reference[3], mean_test[3];
    double ratio[3]; /* mean_test / mean_reference; NAN where the latter is 0 */
    double mean;     /* of the reference over the layer's channels */
    int64_t pixels;  /* that were compared */
    bool finite;     /* no NaN or infinity in either; else they are left out of the sums */
};

/* Which pixels count: those where the reference's scalar layer lies between the two. */
struct difference_where {
    const char *layer; /* as in image_layer_planes */
    double above, below;
};

/* Compares a layer, which is named as in image_layer_planes. ERR_NOT_FOUND when an image lacks it,
 * ERR_MISMATCH for other sizes, ERR_MEMORY. */
int image_difference(const struct image *reference, const struct image *test, const char *layer,
                     struct difference *out, struct fault *fault);

/* Does the same over some of the pixels; `where` NULL: all. ERR_NOT_FOUND also when the reference
 * lacks its layer, ERR_RANGE when that layer is no scalar or no pixel lies there. */
int image_difference_where(const struct image *reference, const struct image *test,
                           const char *layer, const struct difference_where *where,
                           struct difference *out, struct fault *fault);
