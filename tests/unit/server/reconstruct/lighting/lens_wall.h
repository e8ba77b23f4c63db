#pragma once
/* A wall at z = 2, and behind it, right of its edge in the middle, one at z = 8; the focus lies
 * between them. Slopes are 9 and -4.5 pixels. */
#include "proto/plan.h"
#include "server/film/film.h"

enum { SIDE = 200, TILE = 32, L = 3, N = L * L };

#define NEAR_Z 2.0f
#define FAR_Z  8.0f
extern float wall_edge;
extern bool wall_noise; /* paths find light that differs from sample to sample */

void wall_plan(struct plan *plan, uint32_t filter);
float wall_slope(const struct plan *plan, float z);

/* Irradiance grows evenly over the image, so that means of pixels are exact. */
float wall_irradiance(float x, float y);

/* Lands all tiles. */
void wall_land(const struct plan *plan, struct film *film);
