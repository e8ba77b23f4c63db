#pragma once
/* A light's samples as they were traced: their positions and visibility. */
#include "server/reconstruct/shadow/receiver.h"

/* Most pixels of a call, and words of a pixel's bits. */
#define STRATA_RUN   64
#define STRATA_WORDS (SHADOW_STRATA_MAX * SHADOW_STRATA_MAX / 32)

/* Computes the jitters along both axes of `count` (at most STRATA_RUN) pixels: below 1, as the
 * worker placed the strata. */
void strata_jitters(const struct receiver_light *light, const int32_t *x, const int32_t *y,
                    uint32_t count, float *out0, float *out1);

/* Does the same for pixels of a row from (x, y) on. */
void strata_row_jitters(const struct receiver_light *light, int32_t x, int32_t y, uint32_t count,
                        float *out0, float *out1);

/* Reads the strata of pixel i of the patch: bit b of columns[a] tells whether stratum (a, b) is
 * seen, a along axis 0. */
void strata_columns(const struct receiver_light *light, const struct patch *patch, size_t i,
                    uint32_t columns[SHADOW_STRATA_MAX]);

/* Reads the strata of `count` pixels of the patch from `first` on: bit k % 32 of bits[k / 32 *
 * stride + i] tells whether stratum k = b l + a of pixel first + i is seen. */
void strata_bits(const struct receiver_light *light, const struct patch *patch, size_t first,
                 uint32_t count, uint32_t *bits, size_t stride);

/* Estimates the seen fraction of the irradiance of `count` (at most STRATA_RUN) pixels of a row
 * from (x, y) of the image on, from their own samples: sum of I G V over sum of I G at the strata,
 * G = cos cos' / d^2. It is exactly 1 where all strata are seen, and the plain share where none
 * weighs anything. */
void strata_estimate(const struct receiver_light *light, const struct patch *patch,
                     const struct shadow_kernels *kernels, int32_t x, int32_t y, uint32_t count,
                     float *out);
