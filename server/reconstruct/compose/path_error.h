#pragma once
/* Squared standard errors of means over paths.
 *
 * A pixel's paths are stratified against each other, so that their mean is better than their spread
 * says. How much better is told by halves of parts of them (plan_pass_split). Of one pixel that is
 * next to nothing; so the spread says how errors are distributed over the pixels of a cell of
 * PATH_ERROR_CELL_PX squared, and the halves how large they are in all that have about the same:
 *
 *   variance = s I,  I = spread / (n (n - 1)), smoothed a little over the pixels around
 *   H = sum over such pixels of split / (n m), over that of I; m samples are in the parts split
 *
 * Where squared errors of c = 2^L samples fall as c^-a, halves of them make up for each other's
 * errors (their correlation is 2^(1 - a) - 1), and with q = 2^(1 - a)
 *
 *   H = 2 q^(L - 1) - q^L,  and s = q^L for c samples.
 *
 * Between the middles of cells q is interpolated, so that their borders do not show.
 *
 * More samples, of several passes, go on with one sequence: n is the sum of powers of two 2^k, and
 * s the mean of their q^k. */
#include "server/reconstruct/compose/block_variance.h"
#include "server/reconstruct/patch/patch.h"

#define PATH_ERROR_CELL_PX 32

/* Pixels around a block that its errors read; 0 when the plan has no path_spread. */
int32_t path_error_halo_px(const struct plan *plan);

/* Of the block's pixels into out->by_source[ERROR_SOURCE_PATHS]; 0 where n is 1 and without the
 * plane path_spread. A patch with that halo (cut at the image's border) gives the same however the
 * image is cut into blocks, which begin at multiples of PATH_ERROR_CELL_PX. ERR_MEMORY. */
int path_error_find(const struct patch *patch, struct block_variance *out);
