#pragma once
/* The Lambert BRDF, albedo / pi: evaluate, sample, probability density.
 *
 * Samples are cosine-weighted: the unit square is mapped onto the disk by Shirley and Chiu's
 * concentric map (1997, "A low distortion map between disk and square"), then raised onto the
 * hemisphere (Malley). Trigonometry is by polynomials of our own, so that directions are the same
 * bits whatever the C library. */
#include "worker/trace/lanes.h"

#define LAMBERT_INV_PI 0.318309886183790672f

/* The BRDF at any pair of directions above the surface. */
static inline float lambert_evaluate(float albedo)
{
    return albedo * LAMBERT_INV_PI;
}

/* Density of lambert_sample per solid angle at cosine `cos` to the normal; 0 below. */
static inline float lambert_pdf(float cos)
{
    return cos > 0.0f ? cos * LAMBERT_INV_PI : 0.0f;
}

/* Directions around +z from points (u, v) of the unit square. */
void lambert_sample(const float u[LANES], const float v[LANES], struct lanes3 *local);
