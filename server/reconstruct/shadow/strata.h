#pragma once
/* A light's samples as they were traced: where each lay, which were seen. */
#include "server/reconstruct/shadow/receiver.h"

/* Pixels that go at once, and words of a pixel's bits. */
#define STRATA_RUN   64
#define STRATA_WORDS (SHADOW_STRATA_MAX * SHADOW_STRATA_MAX / 32)

/* Along both axes, for `count` (at most STRATA_RUN) pixels: below 1, as the strata were placed. */
void strata_jitters(const struct receiver_light *light, const int32_t *x, const int32_t *y,
                    uint32_t count, float *out0, float *out1);

/* The same of pixels of a row from (x, y) on. */
void strata_row_jitters(const struct receiver_light *light, int32_t x, int32_t y, uint32_t count,
                        float *out0, float *out1);

/* Of pixel i of the patch: bit b of columns[a]: stratum (a, b) is seen, a along axis 0. */
void strata_columns(const struct receiver_light *light, const struct patch *patch, size_t i,
                    uint32_t columns[SHADOW_STRATA_MAX]);

/* Of `count` pixels of the patch from `first` on: bit k % 32 of bits[k / 32 * stride + i]: stratum
 * k = b l + a of pixel first + i is seen. */
void strata_bits(const struct receiver_light *light, const struct patch *patch, size_t first,
                 uint32_t count, uint32_t *bits, size_t stride);

/* Own estimates of the seen fraction of their irradiance of `count` (at most STRATA_RUN) pixels of
 * a row from (x, y) of the image on: sum of I G V over sum of I G at the strata, G = cos cos' /
 * d^2. Exactly 1 where all are seen; the plain share where none counts. */
void strata_estimate(const struct receiver_light *light, const struct patch *patch,
                     const struct shadow_kernels *kernels, int32_t x, int32_t y, uint32_t count,
                     float *out);
