#pragma once
/* Estimates variances of means over paths.
 *
 * A pixel's paths are stratified against each other, so that their mean is better than their spread
 * says. How much better follows from half differences of parts of them (plan_pass_split). A single
 * pixel's are too few. So spreads tell how errors are distributed over a cell of PATH_ERROR_CELL_PX
 * squared pixels, and half differences how large they are over all pixels of about the same spread:
 *
 *   variance = s I,  I = spread / (n (n - 1)), smoothed a little over the pixels around
 *   H = sum over such pixels of split / (n m), over that of I; m samples are in the parts split
 *
 * Where squared errors of c = 2^L samples fall as c^-a, errors of halves cancel in part (their
 * correlation is 2^(1 - a) - 1), and with q = 2^(1 - a)
 *
 *   H = 2 q^(L - 1) - q^L,  and s = q^L for c samples.
 *
 * Between the centres of cells q is interpolated, so that their borders do not show.
 *
 * Samples of later passes continue one sequence: n is the sum of powers of two 2^k, and s the mean
 * of their q^k. */
#include "server/reconstruct/compose/block_variance.h"
#include "server/reconstruct/patch/patch.h"

#define PATH_ERROR_CELL_PX 32

/* Returns how many pixels around a block its errors read; 0 when the plan has no path_m2. */
int32_t path_error_halo_px(const struct plan *plan);

/* Writes variances of the block's pixels into out->by_source[ERROR_SOURCE_PATHS]; 0 where n is 1
 * and without the plane path_m2. The result does not depend on the cut into blocks if the patch
 * has that halo (cut at the image's border) and blocks begin at multiples of PATH_ERROR_CELL_PX.
 * ERR_MEMORY. */
int path_error_find(const struct patch *patch, struct block_variance *out);
