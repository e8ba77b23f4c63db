#pragma once
/* Two pictures after the display transform, as a screen shows them. The perceptual metrics compare
 * these.
 *
 * A pixel v becomes srgb(curve(v * 2^exposure))^(1 / gamma), as in the viewer's shader; the curves
 * are those of view_transform.h. */
#include <stdbool.h>

#include "proto/view_curve.h"
#include "server/image/image.h"

struct display_transform {
    double exposure_ev, gamma;
    enum view_curve curve;
};

#define DISPLAY_PLAIN                                                                              \
    ((struct display_transform){.exposure_ev = 0, .gamma = 1, .curve = VIEW_LINEAR})

/* Arrays of width * height, row by row. Where either picture is not finite, the pixel does not
 * count and both are black. One allocation. */
struct display_pair {
    int32_t width_px, height_px;
    float *reference[3], *test[3]; /* in [0, 1] */
    uint8_t *counts;               /* 1: the pixel counts */
    int64_t count;                 /* of such pixels */
    void *memory;                  /* owned */
};

/* Displays both pictures. `layer` as in image_layer_planes. ERR_MISMATCH for other sizes,
 * ERR_NOT_FOUND, ERR_MEMORY. */
int display_pair_create(const struct image *reference, const struct image *test, const char *layer,
                        const struct display_transform *view, struct display_pair *out,
                        struct fault *fault);
void display_pair_fini(struct display_pair *pair);
