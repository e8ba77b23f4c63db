#pragma once
/* How high what shines on a pixel lies, and what walks the sheared filter takes from that
 * (docs/reconstruction.md, V-plane filter).
 *
 *   a = 1 / max(height, least), weighted by cos^2:  eta = mean, deviation, each over the samples,
 *   then over 5 x 5 pixels of the object that face the same way
 *   sigma_x = min(mu 0.714 / (2 m deviation), cap)
 *
 * m = 3 (n / 16)^(1/3), least is 8 pixels and the cap 8 (of 512 lines the one, of any the other);
 * 0.714 = 2 / 2.8 is the inverse of a clamped cosine's bandlimit. Misses that bring light count as
 * infinitely high.
 *
 * The frame is the worker's, v_plane_tangents of the normal in camera axes, so that samples'
 * directions mean the same here. */
#include "server/reconstruct/indirect/v_plane_neighbourhood.h"

/* Sets the walks of all pixels within V_PLANE_REACH_PX of the neighbourhood's inner rect.
 * ERR_MEMORY. */
int v_plane_slopes(struct v_plane_neighbourhood *around);

/* The filter's standard deviation in pixels on the screen: the mean of both walks'. */
float v_plane_width_px(const struct v_plane_neighbourhood *around, size_t i);
