#pragma once
/* The variance-aware blend (docs/reconstruction.md, Indirect blend). It filters by rule B at four
 * widths and keeps the narrower result where the next wider one differs by more than noise
 * explains.
 *
 *   F_k = rule B at sigma_k = sigma_0 r^k, k = 0 .. 3, from twice to half its width
 *   D_k = smoothed (F_k - F_k-1)^2
 *   out = F_3;  for k = 3, 2, 1: out = F_k-1 + max(1 - c V_k / D_k, 0) (out - F_k-1)
 *
 * V_k is the noise's variance in F_k. Where the noise of pixels is independent, of variance v,
 *
 *   cov(F_j, F_k) = v / (2 pi (sigma_j^2 + sigma_k^2)), so V_k = v / (4 pi sigma_k^2),
 *   var(F_k - F_k-1) = w V_k,  w = 1 + r^2 - 4 r^2 / (1 + r^2)
 *
 * Where the wider one is off by b besides, D_k = b^2 + w V_k in the mean, and the mix of least
 * error has the factor 1 - c V_k / D_k, c = 1 - 2 r^2 / (1 + r^2).
 *
 * v is what a narrow mean of fixed width takes off a pixel, smoothed. F_3 would not do: near
 * corners it is hardly wider than a pixel and takes off nothing.
 *
 * Neighbours' noise is not independent, though: jitters differ the more the nearer pixels are, and
 * wide filters leave less of such noise than independence predicts, so that narrower results would
 * be kept for noise. The differences themselves show how much is left: V_k is limited to r^2 V_k+1
 * and to r^2 D_k+1 / w, what the next finer step would leave of its whole difference.
 *
 * Differences are relative to F_0 and summed over the channels: all channels share one decision,
 * whatever their units.
 *
 * Measured against rule B alone at 256 rows and 64 to 256 samples a pixel, the error is 1 to 5 %
 * lower in rooms of one bounce, and 5 to 30 % lower in others of four bounces, with gloss or under
 * an environment. At 36 samples it is from 6 % higher to 20 % lower. The blend costs four times
 * rule B's passes.
 *
 * The widest filter is limited by the block's halo. From about 800 rows at 64 samples (fewer rows
 * at fewer samples) it is less than twice rule B's width, from 1700 less than that width itself,
 * and the blend is noisier. At 64 samples nothing is gained at 1080 rows, and at 2160 the error is
 * a seventh to a quarter higher. */
#include "server/reconstruct/indirect/indirect_pass.h"

/* Returns the number of spare arrays of a neighbourhood that blends `count` channels. The first
 * `count` hold the channels and become the result; the next one becomes its width in scene
 * units. */
uint32_t indirect_blend_spares(uint32_t count);

/* Returns the spare that then holds channel c, blended likewise from the next narrower levels, with
 * rule->ratio times the width. */
uint32_t indirect_blend_narrower(uint32_t count, uint32_t c);

/* Blends `count` channels over `rect`, by the differences of the first `voters` of them. The
 * neighbourhood reaches indirect_halo_px around `rect`. `counts` is as in indirect_widths. */
void indirect_blend(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                    struct indirect_neighbourhood *around, const float *counts, struct rect rect,
                    uint32_t count, uint32_t voters);
