#pragma once
/* What Open Image Denoise makes of a picture with guides, by its network. */
#include "proto/plane.h"
#include "tests/bench/unet/network.h"

/* Planes of R, G and B, or of X, Y and Z, of one size. */
struct denoise_input {
    const struct plane *const *colour, *const *albedo, *const *normal;
};

/* Fills planes of the same size. Returns 0, or an error with its sentence. *exposure is that by
 * which the network sees the picture. */
int denoise_run(const struct network *network, const struct denoise_input *in,
                const struct plane *const out[3], float *exposure, struct fault *fault);
