#pragma once
/* Tells whether a picture differs from a reference by more than its noise: z = (test - reference) /
 * se, pixel by pixel and channel by channel, with se the standard error of the difference. */
#include "server/image/image.h"

/* Standard errors that are correct give: mean 0, rms 1, median |z| 0.674; beyond 2, 3, 4:
 * 0.0455, 0.0027, 0.00006. Where the reference's own noise is unknown and left out, z spreads
 * wider; where samples are stratified and standard errors take them for independent, it spreads
 * less. */
struct zscore {
    uint64_t count;   /* values with a standard error above 0 */
    uint64_t without; /* values left out: without one, or not finite */
    double mean, rms;
    double median;    /* of |z| */
    double beyond[3]; /* share of |z| above 2, 3 and 4 */
    double worst;     /* the z farthest from 0 */
    int32_t worst_x, worst_y;
    int worst_channel;    /* 0, 1, 2: red, green, blue */
    double mean_error[3]; /* standard error of the mean over all pixels of the test, by channel */
    double relmse;        /* what the noise of the test alone adds to difference.h's relmse */
};

/* Judges the layer beauty, whose standard error is the layer "error": the test image must have
 * one (ERR_NOT_FOUND), and if the reference does too, se^2 is the sum of both squares.
 * ERR_MISMATCH for other sizes, ERR_MEMORY. Without a single standard error above 0 all figures
 * are 0. `mean` is difference.h's mean of the reference, for relmse. */
int image_zscore(const struct image *reference, const struct image *test, double mean,
                 struct zscore *out, struct fault *fault);
