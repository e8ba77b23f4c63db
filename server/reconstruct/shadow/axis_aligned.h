#pragma once
/* The axis-aligned filter (Mehta et al. 2012, separable as in 2013), with a refusal of neighbours
 * whose own shadow is sharper: the fast mode, at a sixth to a third of the sheared filter's cost.
 *
 *   beta     m(N) mu / k max(sigma_y s_min, one pixel), k = 3; sigma_y of the light's shorter side
 *   passes   along x, then along y, with the receiving pixel's beta: w = exp(-|d|^2 / 2 beta^2),
 *            |d| < 3 beta
 *   refused  neighbours q with |d| > sigma_y s_min(q) */
#include "server/reconstruct/shadow/wedge.h"

#define AXIS_ALIGNED_REACH_PX SHADOW_REACH_PX

/* Blurs own values over receivers, of which `inner` must lie AXIS_ALIGNED_REACH_PX within their
 * rect. Of `count` pixels of `inner` with a wedge: seen[k], and width[k]: beta in pixels.
 * ERR_MEMORY. */
int axis_aligned_filter(const struct receiver_light *light, const struct patch *patch,
                        const struct wedges *wedges, const struct shadow_kernels *kernels,
                        const struct receivers *receivers, struct rect inner,
                        const uint32_t *pixels, uint32_t count, float *seen, float *width);
