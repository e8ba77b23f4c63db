#pragma once
/* A layer of the network: windows of 3 by 3 pixels over all channels, a bias, and the larger of
 * zero and that. */
#include "tests/bench/unet/tensor.h"
#include "tests/bench/unet/tza.h"

struct convolution {
    int32_t inputs, outputs;
    float *weights;  /* owned; [block of outputs][row][column][input][lane] */
    float *bias;     /* owned; zeros behind the last output */
    int32_t threads; /* 0: one for each core */
};

/* Takes NAME.weight ("oihw") and NAME.bias ("x") of an archive. ERR_MISSING, ERR_MISMATCH or
 * ERR_MEMORY. */
int convolution_init(struct convolution *c, const struct tza *tza, const char *name,
                     struct fault *fault);
void convolution_fini(struct convolution *c);

/* Computes *out from `in`. The channels of *out are the outputs, rounded up to whole
 * blocks of lanes by channels of zeros. ERR_MEMORY, and ERR_MISMATCH if `in` has other channels. */
int convolution_run(const struct convolution *c, const struct tensor *in, struct tensor *out);
