#pragma once
/* The axis-aligned filter (Mehta et al. 2012, separable as in 2013). It is the fast mode, at a
 * sixth to a third of the sheared filter's cost. Beyond the paper, it refuses neighbours whose own
 * shadow is sharper.
 *
 *   beta     m(N) mu / k max(sigma_y s_min, one pixel), k = 3; sigma_y of the light's shorter side
 *   passes   along x, then along y, with the receiving pixel's beta: w = exp(-|d|^2 / 2 beta^2),
 *            |d| < 3 beta
 *   refused  neighbours q with |d| > sigma_y s_min(q) */
#include "server/reconstruct/shadow/wedge.h"

#define AXIS_ALIGNED_REACH_PX SHADOW_REACH_PX

/* Blurs the receivers' own values. `inner` must lie AXIS_ALIGNED_REACH_PX within their rect. Writes
 * seen[k] and width[k], which is beta in pixels, of `count` pixels of `inner` with a wedge.
 * ERR_MEMORY. */
int axis_aligned_filter(const struct receiver_light *light, const struct patch *patch,
                        const struct wedges *wedges, const struct shadow_kernels *kernels,
                        const struct receivers *receivers, struct rect inner,
                        const uint32_t *pixels, uint32_t count, float *seen, float *width);
