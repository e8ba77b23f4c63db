#pragma once
/* Averages over the lens under Gaussians as wide as the least slope of a pixel's samples allows.
 * One pass goes along x and one along y, with the receiving pixel's width (docs/reconstruction.md,
 * Lens samples). */
#include "server/reconstruct/lens/lens.h"

#define LENS_AXIS_ALIGNED_REACH_PX 16

int lens_axis_aligned(const struct plan *plan, const struct patch *patch, struct rect inner,
                      float *const out[3], float *width_px, struct lens_statistics *statistics);
