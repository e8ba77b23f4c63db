#pragma once
/* Second sets of paths through the lens (lens_extra of the plan): which pixels need them most, and
 * how they change the picture.
 *
 * Errors are estimated from the first set as it is lit in the picture. Where light fields of pixel
 * centres light its samples, their light is filtered by then and shows little noise.
 *
 * A filter along slopes mixes samples of many pixels where these are far out of focus, and of few
 * near it. So a pixel's error follows from the variance of its samples, each weighted by how few
 * others it is mixed with: w = 1 / (1 + pi s^2) for slope s, the area of its circle of confusion.
 * The expected squared error is sum w |c - m|^2 / (n (n - 1)) of n samples c and their weighted
 * mean m.
 *
 * The second set's mean B, whose error is known, and the filtered picture F are mixed by their
 * squared errors e_B and e_F: F + (B - F) e_F / (e_F + e_B), where errors are means over those of
 * the 7 x 7 pixels around that have second sets. */
#include "server/reconstruct/patch/patch.h"

/* Writes the error level of each pixel of `inner`, row by row. 0 is none; else two steps are a
 * doubling of the squared error. Reads a pixel around it where the patch has one. ERR_MEMORY. */
int lens_second_set_levels(const struct plan *plan, const struct patch *patch, struct rect inner,
                           uint8_t *levels);

/* Mixes second sets into the filtered picture of `inner`, arrays of the patch's size. Reads three
 * pixels around it where the patch has them, as every patch has that does not end with the picture.
 * ERR_MEMORY. */
int lens_second_set_mix(const struct plan *plan, const struct patch *patch, struct rect inner,
                        float *const out[3]);
