#pragma once
/* The light field of glossy lobes from few samples.
 *
 * Virtual hits (docs/reconstruction.md, Glossy lobes): a pixel's lobe is a Gaussian around the
 * mirrored direction, and its hit lies at the distance that the mean of 1 / distance gives.
 * Neighbours are weighted by how alike their lobes see the same points. One pass goes along x and
 * one along y, with the receiving pixel's lobe and distance. Light and weights are filtered, and
 * their quotient is the mean radiance that the lobe sees. With n samples and the plan's mu,
 *
 *   weight = similarity^(2 / c^2) exp(-px^2 / (2 cap^2)),  c = 0.42 mu (16 / n)^0.3,
 *   cap = 5 mu (16 / n)^(1/6) px * height / 512; both shrink, so that errors vanish.
 *
 * Lobes as published (Tokuyoshi 2015, equations 11 to 13) are compared with: the same passes,
 * widths and neighbours, with lobes that know their axes and widths and not how far away is what
 * they see. They are spherical Gaussians (SG), mixtures of them, or Gaussians over an ellipse
 * (ASG).
 *
 * Bandlimits (Mehta et al. 2013, "Axis-aligned filtering for interactive physically-based diffuse
 * indirect lighting", section 5): rule A of indirect.h with a bandlimit of 3.6 + 0.084 m in place
 * of a clamped cosine's 2.8. That is Blinn and Phong's, whose facets are spread as GGX's are for m
 * = 2 / alpha^2 - 2 (Walter et al. 2007); z is 1 / the mean of 1 / distance. It
 * serves as a baseline: it ignores how lobes turn with normals, and edges of roughness.
 *
 * Under a plan that has rounds n is the receiving pixel's own.
 *
 * The result is radiance that the reflectance multiplies. The filter is a pure function of its
 * arguments; any thread may call it. */
#include "server/reconstruct/patch/patch.h"

struct glossy_statistics {
    uint64_t pixels_filtered;
    uint64_t pixels_skipped; /* no glossy lobe, or seen at grazing angles */
    uint64_t blocks_skipped; /* of only such pixels: no pass ran */
};

/* Returns how many pixels around a block the plan's filter reads; 0 for GLOSSY_FILTER_NONE. It
 * depends on the plan alone and is at most 1.5 GLOSSY_REACH_MAX_PX, or what indirect.h says for
 * bandlimits. */
int32_t glossy_halo_px(const struct plan *plan);

/* Filters over `inner`, which lies in patch->rect. The patch needs depth, normal, id and the planes
 * of glossy lobes. Writes out[c] for the pixels of `inner`, 0 where there is no lobe, and adds to
 * *statistics. The plain average is what was measured, without weights. ERR_MEMORY; ERR_RANGE for
 * another filter, a missing plane or an `inner` outside. */
int glossy_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                  float *const out[3], struct glossy_statistics *statistics);

/* Does the same and writes variance[c] of out[c] (glossy_variance.h), for a plan of which
 * patch_knows_glossy_errors. */
int glossy_filter_with_error(const struct plan *plan, const struct patch *patch, struct rect inner,
                             float *const out[3], float *const variance[3],
                             struct glossy_statistics *statistics);
