#pragma once
/* The Lambert BRDF, albedo / pi: evaluate, sample, probability density.
 *
 * Samples are cosine-weighted: the unit square is mapped onto the disk by Shirley and Chiu's
 * concentric map (1997, "A low distortion map between disk and square"), then raised onto the
 * hemisphere (Malley). Trigonometry is by polynomials of our own, so that directions are the same
 * bits whatever the C library. */
#include <math.h>

#include "worker/shade/elementary.h"
#include "worker/shade/lanes.h"

#define LAMBERT_INV_PI 0.318309886183790672f
/* The square of the least height of a direction. Directions on the disk's rim rise, too, since it
 * is undefined what a ray along the surface meets. */
#define LAMBERT_RISE2 0x1p-24f

/* Returns the density of lambert_sample per solid angle at cosine `cos` to the normal; 0 below. */
static inline float lambert_pdf(float cos)
{
    return cos > 0.0f ? cos * LAMBERT_INV_PI : 0.0f;
}

/* Computes the direction around +z for the point (u, v) of the unit square; z is above 0. */
static inline void lambert_direction(float u, float v, float *x, float *y, float *z)
{
    float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
    int wide = fabsf(a) > fabsf(b);
    float radius = wide ? a : b, other = wide ? b : a;
    float divisor = radius == 0.0f ? 1.0f : radius; /* the centre: both are 0 */
    float angle = other / divisor * (0.25f * ELEMENTARY_PI);
    float c = elementary_small_cos(angle), s = elementary_small_sin(angle);
    float height = 1.0f - radius * radius;
    *x = radius * (wide ? c : s);
    *y = radius * (wide ? s : c);
    *z = sqrtf(height > LAMBERT_RISE2 ? height : LAMBERT_RISE2);
}

/* Does the same for sixteen points. */
void lambert_sample(const float u[LANES], const float v[LANES], struct lanes3 *local);
