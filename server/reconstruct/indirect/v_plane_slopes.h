#pragma once
/* Heights of the reflectors above a pixel, and the sheared filter's walks that follow
 * (docs/reconstruction.md, V-plane filter).
 *
 *   a = 1 / max(height, least), weighted by cos^2:  eta = mean, deviation, each over the samples,
 *   then over 5 x 5 pixels of the object that face the same way
 *   sigma_x = min(mu 0.714 / (2 m deviation), cap)
 *
 * m = 3 (n / 16)^(1/3). `least` is 8 pixels at 512 rows and scales with their number; the cap is 8
 * pixels at any number of rows; 0.714 = 2 / 2.8 is the inverse of a clamped cosine's bandlimit.
 * Misses that bring light count as infinitely high.
 *
 * The frame is the worker's, v_plane_tangents of the normal in camera axes, so that directions of
 * samples agree. */
#include "server/reconstruct/indirect/v_plane_neighbourhood.h"

/* Sets the walks of all pixels within V_PLANE_REACH_PX of the neighbourhood's inner rect.
 * ERR_MEMORY. */
int v_plane_slopes(struct v_plane_neighbourhood *around);

/* Returns the filter's standard deviation in pixels on the screen, the mean of both walks'. */
float v_plane_width_px(const struct v_plane_neighbourhood *around, size_t i);
