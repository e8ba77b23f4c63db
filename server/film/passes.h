#pragma once
/* Adding up the passes of a tile's paths. */
#include "proto/samples.h"

/* Adds the sums of `more`, which holds more_spp samples a pixel, to those of `sum`, which holds
 * sum_spp; both at least 1. Both have the plan's planes of paths; other planes of `sum` stay as
 * they are.
 *
 * PATH_SPREAD, the squared deviations from the mean, is merged by the formula of Chan, Golub and
 * LeVeque (Updating formulae and a pairwise algorithm for computing sample variances, 1979,
 * equation 2.1): S = S_a + S_b + d^2 n_a n_b / (n_a + n_b), with d the difference of the means of
 * PATH_RADIANCE. */
void passes_add(struct samples *sum, uint32_t sum_spp, const struct samples *more,
                uint32_t more_spp);
