#pragma once
/* A light's samples as they were traced: where each lay, which were seen. */
#include "server/reconstruct/receiver.h"

/* Along both axes, for `count` (at most STRATA_RUN) pixels: below 1, as the strata were placed. */
#define STRATA_RUN 64
void strata_jitters(const struct receiver_light *light, const int32_t *x, const int32_t *y,
                    uint32_t count, float *out0, float *out1);

/* Of pixel i of the patch: bit b of columns[a]: stratum (a, b) is seen, a along axis 0. */
void strata_columns(const struct receiver_light *light, const struct patch *patch, size_t i,
                    uint32_t columns[SHADOW_STRATA_MAX]);
bool strata_all_seen(const struct receiver_light *light, const struct patch *patch, size_t i);

/* The pixel's own estimate of the seen fraction of its irradiance: sum of I G V over sum of I G at
 * its strata, G = cos cos' / d^2. Exactly 1 where all are seen; the plain share where none counts.
 * (x, y) in the image. */
float strata_ratio(const struct receiver_light *light, const struct patch *patch, int32_t x,
                   int32_t y);
