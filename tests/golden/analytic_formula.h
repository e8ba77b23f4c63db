#pragma once
/* Closed forms and quadratures in double precision, independent of what they are to judge. */
#include <stdbool.h>

/* Irradiance at `point` with unit `normal` by a one-sided parallelogram (centre c, half sides u, v,
 * shining where u x v points) of radiance 1: Lambert's polygon formula, cut at the horizon. */
double formula_rectangle(const double c[3], const double u[3], const double v[3],
                         const double point[3], const double normal[3]);

/* The same under a profile exp(-2 (a^2 + b^2)), a and b in [-1, 1] along u and v; everything above
 * the horizon. */
double formula_gaussian_rectangle(const double c[3], const double u[3], const double v[3],
                                  const double point[3], const double normal[3]);

/* Share of the cosine-weighted hemisphere over a floor that a tall, long wall leaves open, when
 * rays of length `reach` start at `distance` from it. */
double formula_corner_openness(double distance, double reach);

/* Share of light that a white GGX mirror of roughness alpha reflects towards cos_o, F = 1, by
 * Smith's masking of both directions together (Heitz 2014, eq. 99). */
double formula_ggx_albedo(double cos_o, double alpha);

/* Schlick's Fresnel. */
double formula_schlick(double f0, double cosine);

/* All that leaves a clear slab of inner transmittance t with reflectance f at both faces when
 * radiance 1 comes from everywhere, seen along the normal. */
double formula_slab(double f, double t);

double formula_dot(const double a[3], const double b[3]);
void formula_cross(const double a[3], const double b[3], double out[3]);
void formula_normalise(double v[3]);
