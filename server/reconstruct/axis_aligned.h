#pragma once
/* The axis-aligned filter (Mehta et al. 2012, separable as in 2013), with a refusal of neighbours
 * whose own shadow is sharper: the fast mode, a tenth of the sheared filter's cost.
 *
 *   beta = m(N) mu / k max(sigma_y s_min, one pixel), k = 3; sigma_y of the light's shorter side
 *   along x, then along y, with the receiving pixel's beta: w = exp(-|d|^2 / 2 beta^2), |d| < 3
 * beta refused: neighbours q with |d| > sigma_y s_min(q) */
#include "server/reconstruct/wedge.h"

#define AXIS_ALIGNED_REACH_PX SHADOW_REACH_PX

/* Blurs own values over receivers, of which `inner` must lie AXIS_ALIGNED_REACH_PX within their
 * rect. The result is in the sources' `seen`, widths in the targets' `width`. ERR_MEMORY. */
int axis_aligned_filter(const struct receiver_light *light, const struct patch *patch,
                        const struct wedges *wedges, const struct shadow_kernels *kernels,
                        struct receivers *receivers, struct rect inner);

/* beta in pixels of a filtered receiver; 0 without wedge. */
float axis_aligned_width_px(const struct shadow_target *target);
