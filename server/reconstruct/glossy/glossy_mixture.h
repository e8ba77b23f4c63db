#pragma once
/* GGX facets as a mixture of spherical Gaussians, in place of one of them. With x the angle to the
 * normal over alpha they are spread as 1 / (1 + x^2)^2. The amplitudes a and sharpnesses b of the
 * sum of a exp(-b x^2) are fitted to that by least squares over solid angle; it is off by 3 %,
 * where one Gaussian, b = 1.13, is off by 14 %. (docs/reconstruction.md, Lobes as published.) */
#define GLOSSY_MIXED 2

/* Sharpnesses over that of the one Gaussian, and amplitudes. The last is the widest. */
static const float glossy_mixed_times[GLOSSY_MIXED] = {1.764602f, 0.339381f};
static const float glossy_mixed_amount[GLOSSY_MIXED] = {0.764f, 0.2052f};
