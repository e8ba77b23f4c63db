#pragma once
/* The variance-aware blend (docs/reconstruction.md, Indirect blend): rule B at four widths around
 * its own; where the next wider one differs by more than noise explains, the narrower stands.
 *
 *   F_k = rule B at sigma_k = sigma_0 r^k, k = 0 .. 3, from twice to half its width
 *   D_k = smoothed (F_k - F_k-1)^2
 *   out = F_3;  for k = 3, 2, 1: out = F_k-1 + max(1 - c V_k / D_k, 0) (out - F_k-1)
 *
 * with V_k the noise's variance in F_k. Where the noise of pixels is independent, of variance v,
 *
 *   cov(F_j, F_k) = v / (2 pi (sigma_j^2 + sigma_k^2)), so V_k = v / (4 pi sigma_k^2),
 *   var(F_k - F_k-1) = w V_k,  w = 1 + r^2 - 4 r^2 / (1 + r^2)
 *
 * and where the wider one is off by b besides, D_k = b^2 + w V_k in the mean, and what mixes the
 * two with the least error is 1 - c V_k / D_k, c = 1 - 2 r^2 / (1 + r^2).
 *
 * v is what a narrow mean of fixed width takes off a pixel, smoothed. F_3 would not do: near
 * corners it is hardly wider than a pixel, and what it takes off tells nothing. Neighbours' noise
 * is not independent, though: jitters differ the more the nearer pixels are, and of such noise less
 * is left by wide filters than by independence, so that the narrower would stand for noise. What a
 * level has of it shows in the differences themselves: V_k is at most r^2 V_k+1 and r^2 D_k+1 / w,
 * what the next finer step would leave of all that it differs by.
 *
 * Differences are relative to F_0 and summed over the channels: one decision for all of them,
 * whatever their units.
 *
 * Measured against rule B alone at 256 lines and 64 to 256 samples a pixel: in rooms of one bounce
 * 1 to 5 % less error, in others of four bounces, with gloss or under an environment 5 to 30 %
 * less; at 36 samples from 6 % more to 20 % less. It costs four times rule B's passes.
 *
 * The widest is bounded by what a block sees around it: from about 800 lines at 64 samples (fewer
 * samples: fewer lines) it is less than twice rule B's width, from 1700 less than that itself, and
 * the blend noisier. At 64 samples there is nothing to gain at 1080 lines, and at 2160 there is a
 * seventh to a quarter more error. */
#include "server/reconstruct/indirect/indirect_pass.h"

/* Spare arrays of a neighbourhood that blends `count` channels: the first `count` hold them and
 * become the result, the next one becomes its width in scene units. */
uint32_t indirect_blend_spares(uint32_t count);

/* The spare that then holds channel c blended in the same way of the next narrower levels, with
 * rule->ratio times the width. */
uint32_t indirect_blend_narrower(uint32_t count, uint32_t c);

/* Blends `count` channels, as the differences of the first `voters` of them say, over `rect`, of a
 * neighbourhood that reaches indirect_halo_px around it. `counts` as in indirect_widths. */
void indirect_blend(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                    struct indirect_neighbourhood *around, const float *counts, struct rect rect,
                    uint32_t count, uint32_t voters);
