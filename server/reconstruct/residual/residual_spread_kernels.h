#pragma once
/* Means over few and far pixels that show alike surfaces, and what is believed of them, once for
 * each instruction set. All compute the same bits. */
#include <stdbool.h>

#include "proto/runtime/kernels.h"
#include "server/reconstruct/residual/residual_field.h"

#define RESIDUAL_SPREAD_LEVELS 4
#define RESIDUAL_SPREAD_TAPS   2 /* on each side */

/* Pixels to each side that tell what one does not know for itself. */
#define RESIDUAL_SPREAD_AROUND 2

/* Differences at which features have nothing in common. */
#define RESIDUAL_TURN_MAX      0.3f  /* square of the way from a normal to another */
#define RESIDUAL_NEARNESS_PART 0.06f /* of it, beyond what slopes tell */

/* Light of three channels, and the variance of their sum. */
enum { RESIDUAL_SPREAD_VARIANCE = 3, RESIDUAL_SPREAD_CHANNELS = 4 };

/* How far the taps of a mean are, and what they count. */
struct residual_spread_level {
    int32_t step_px;
    float weight[RESIDUAL_SPREAD_TAPS + 1]; /* of the pixel and of those on each side */
    float squares; /* sum of squared weights over the square of their sum */
    float lower;   /* variances along an axis, over those before, where all taps count */
};

/* A line of pixels whose means are wanted. */
struct residual_spread_line {
    const struct residual_features *f;
    const struct residual_spread_level *level;
    const float *slope;  /* along the line's axis */
    ptrdiff_t step;      /* from a tap to the next */
    int32_t first, last; /* taps that there are */
    bool lobes;          /* lobes' directions count, too */
    float lobe_px2; /* square of the pixels that a lobe of roughness 1 shows alike; 0: of all */
    float *few;     /* variance of the mean over that of a single pixel; follows it */
};

/* Means of all levels, and what pixels know of the widest. */
struct residual_spread_means {
    float *of[RESIDUAL_SPREAD_LEVELS][RESIDUAL_SPREAD_CHANNELS];
    float lower2[RESIDUAL_SPREAD_LEVELS]; /* squares of levels' `lower` */
    float *few;         /* variance of the widest mean over that of a single pixel */
    const float *shown; /* 1 where a surface is, else 0 */
    float *known[3];    /* light, times weight */
    float *weight;      /* 0 where nothing is shown */
    float *variance;    /* of the widest mean, times weight */
    size_t stride;
};

struct residual_spread_kernels {
    /* Computes means of pixels [p, p + count) and of what is around them, in whole vectors. Taps
     * have spikes in common, so that variances fall to `lower` where all count, and by less where
     * fewer do. */
    void (*mean_row)(const struct residual_spread_line *l, size_t p, size_t count,
                     float *const in[RESIDUAL_SPREAD_CHANNELS],
                     float *const out[RESIDUAL_SPREAD_CHANNELS]);

    /* Finds what pixels [p, p + count) know, in whole vectors. */
    void (*know_row)(const struct residual_spread_means *m, size_t p, size_t count);

    /* Decides how much light each of these pixels has, from what RESIDUAL_SPREAD_AROUND pixels
     * around know. */
    void (*decide_row)(const struct residual_spread_means *m, size_t p, size_t count,
                       float *const out[3]);
};

extern const struct residual_spread_kernels residual_spread_kernels_sse42,
    residual_spread_kernels_avx2, residual_spread_kernels_avx512;
