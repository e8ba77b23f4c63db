#pragma once
/* The U-Net of Open Image Denoise 2 (Afra, github.com/RenderKit/oidn, core/unet_filter.cpp): four
 * levels of halved size, from which details come back level by level beside what went down. */
#include "tests/bench/unet/convolution.h"

#define NETWORK_LAYERS   16
#define NETWORK_INPUTS   9  /* colour, albedo, normal */
#define NETWORK_MULTIPLE 16 /* what width and height must be multiples of */

struct network {
    struct convolution layers[NETWORK_LAYERS];
};

/* Takes the layers from an archive of weights. ERR_MISSING, ERR_MISMATCH, ERR_MEMORY. What was
 * taken is to be freed even after an error. */
int network_init(struct network *n, const struct tza *tza, struct fault *fault);
void network_fini(struct network *n);

/* Makes it run on so many threads; 0: one for each core, as it does from the start. */
void network_set_threads(struct network *n, int32_t threads);

/* Computes *out, whose first three channels are the picture, from `in`. */
int network_run(const struct network *n, const struct tensor *in, struct tensor *out,
                struct fault *fault);
