#pragma once
/* Second sets of paths through the lens (plan's lens_extra): which pixels need them most, and what
 * the picture becomes by them.
 *
 * The first set is told of as it is lit in the picture: where light fields of pixel centres light
 * its samples, their light is filtered by then, and hardly tells of noise.
 *
 * A filter along slopes mixes many pixels' samples where these are far out of focus, and hardly any
 * near it. So a pixel's error is told by its samples' variance, each weighed by how few others are
 * mixed with it: 1 / (1 + pi s^2) for slope s, the area of its circle of confusion. The squared
 * error is in the mean sum w |c - m|^2 / (n (n - 1)) of n samples c and their weighted mean m.
 *
 * The second set's mean B, whose error is known, and the filtered picture F are mixed by their
 * squared errors e_B and e_F: F + (B - F) e_F / (e_F + e_B), where errors are means over those of
 * the 7 x 7 pixels around that have second sets. */
#include "server/reconstruct/patch/patch.h"

/* Writes how large the error of each pixel of `inner` is, row by row: 0: none; else two steps for
 * each doubling of its square. Reads a pixel around it where the patch has one. ERR_MEMORY. */
int lens_extra_levels(const struct plan *plan, const struct patch *patch, struct rect inner,
                      uint8_t *levels);

/* Mixes into the filtered picture of `inner`, arrays of the patch's size, what second sets bring.
 * Reads three pixels around it where the patch has them, as every patch has that does not end with
 * the picture. ERR_MEMORY. */
int lens_extra_mix(const struct plan *plan, const struct patch *patch, struct rect inner,
                   float *const out[3]);
