#pragma once
/* Structural similarity of two pictures as shown: Wang, Bovik, Sheikh and Simoncelli 2004, "Image
 * quality assessment: from error visibility to structural similarity", equation 13, with a Gaussian
 * window of 11 x 11, sigma 1.5, K1 = 0.01, K2 = 0.03, on Rec. 709 luma in [0, 1]. */
#include "server/compare/display_transform.h"

/* Computes map[i], width * height: 1 where the windows around are the same. Windows are cut at the
 * border and at pixels that do not count, and their weights made to sum to one; where a pixel does
 * not count the map is 1. *mean is over windows that lie wholly in the picture, as the paper has
 * it, or over all when none does; 1 when no pixel counts. ERR_MEMORY. */
int ssim_map(const struct display_pair *pair, float *map, double *mean);
