#pragma once
/* Adaptive sampling of indirect light: from the nearest and farthest distances that the first rays
 * met follow the number of rays that a pixel needs, of bounces and of its glossy lobe, and the
 * width of its filter (Mehta et al. 2013, "Axis-aligned filtering for interactive physically-based
 * diffuse indirect lighting", sections 4.1 to 4.3 and 5).
 *
 * A receiver's surface is a low-pass filter of bandlimit Omega over directions; z_near and z_far
 * bound the distances of what lights it, and d is a pixel's size there:
 *
 *   Omega_x = mu min(Omega / z_near, alpha / d)                                  equation 15
 *   beta    = 2 / Omega_x                                                        equation 16
 *   n       = gamma (mu Omega d / z_near + a)^2 Omega^2 (1 + mu z_far / z_near)^2    equation 21
 *
 * The paper has one alpha of 0.3 in both. In the width it forces 6.7 px on every contact and blurs
 * it (docs/reconstruction.md, Indirect widths), so alpha is 3 there. In the rate 3 would ask for
 * 113 rays and more at every pixel, so a stays 0.3. Distances below INDIRECT_ADAPTIVE_NEAR_PX (at
 * 512 rows) count as that, which is the paper's 2 % of the scene, in pixel sizes.
 *
 * For the error to fall as mu grows, the number of rays must grow faster than the area under the
 * filter shrinks, also where equation 21 asks for fewer rays than the first set has: from mu = 1 on
 * each pixel that sees anything gets at least first mu^3 rays. (With the paper's rates alone the
 * error of a reflector above a floor grows from mu 0.5 to 2 and never falls.) Below 1 widths stay
 * as they are at 1, and only rays become fewer: wider filters had a fifth more error in a box.
 *
 * Distances are pooled over the object's pixels around, so that they hardly depend on the pixel's
 * own rays. Otherwise bright pixels would get more rays than dark ones, and the mean over both sets
 * would be too dark. */
#include "server/reconstruct/patch/patch.h"

#define INDIRECT_OMEGA_LAMBERT        2.8f /* equation 18: 95 % of the energy */
#define INDIRECT_GAMMA_LAMBERT        0.4f /* section 4.3, of cosine-distributed rays */
#define INDIRECT_ADAPTIVE_ALPHA       0.3f
#define INDIRECT_ADAPTIVE_WIDTH_ALPHA 3.0f
#define INDIRECT_ADAPTIVE_NEAR_PX     8.0f
#define INDIRECT_ADAPTIVE_LINES       512.0f /* rows at which these pixels are counted */

/* A receiver's surface: the bandlimit of its transfer function, and the share of rays that suffices
 * since they are distributed by it. */
struct indirect_bandlimit {
    float omega, gamma;
};

struct indirect_bandlimit indirect_bandlimit_lambert(void);
/* Returns the bandlimit of an exponent (section 5), fitted to 4 .. 50. gamma = acos(cos(45
 * deg)^(1/m)) / 90 deg (section 4.3). Exponents below 1 count as 1. */
struct indirect_bandlimit indirect_bandlimit_blinn_phong(float exponent);
/* Returns the bandlimit of GGX facets of an alpha. It is Blinn and Phong's for the exponent m = 2 /
 * alpha^2 - 2, whose facets are spread about as widely (Walter et al. 2007, "Microfacet models for
 * refraction through rough surfaces", section 5.2). Above 50, where the fit ends, Omega grows with
 * the root of m: on the fit's straight line a floor of alpha 0.04 would ask for eight times the
 * rays at least. */
struct indirect_bandlimit indirect_bandlimit_facets(float alpha);

/* Distances that one pixel's rays met, and the pixel's size there; all above 0, in one unit. */
struct indirect_span {
    float near, far, pixel;
};

/* Return beta, in the span's unit, and n. mu > 0. The results are finite and not limited
 * otherwise. */
float indirect_adaptive_width(const struct indirect_bandlimit *band, float mu,
                              const struct indirect_span *span);
float indirect_adaptive_rays(const struct indirect_bandlimit *band, float mu,
                             const struct indirect_span *span);

/* Returns the mu of widths. */
float indirect_adaptive_width_mu(float mu);

/* Returns the strata per axis of a pixel's second set: n - first, rounded to a square. The pixel
 * asks for `rays` in all, has `first` and may get `most`. */
uint32_t indirect_adaptive_strata(float rays, uint32_t first, uint32_t most);

/* Computes the strata per axis of every pixel's second set over `inner`, row by row; 0 where the
 * first set is enough or met nothing. Receivers are Lambertian, and the plan is of
 * INDIRECT_FILTER_ADAPTIVE. The patch holds the first set of `inner` and INDIRECT_NEAR_PX around.
 * ERR_MEMORY; ERR_RANGE without such planes. */
int indirect_adaptive_find(const struct plan *plan, const struct patch *patch, struct rect inner,
                           uint8_t *strata_map);

/* Does the same for rays of glossy lobes, by their distances and their facets' bandlimits. The plan
 * has two strata maps. */
int indirect_adaptive_find_lobes(const struct plan *plan, const struct patch *patch,
                                 struct rect inner, uint8_t *strata_map);
