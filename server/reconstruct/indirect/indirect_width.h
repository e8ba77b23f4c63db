#pragma once
/* Widths of the filters of indirect light (docs/reconstruction.md, Indirect widths):
 *
 *   beta = mu clamp((2 / 2.8) max(z_s, least z) / mu(n), 0.6 px, cap(n))
 *
 * 2.8 is the bandlimit of a clamped cosine (Mehta et al. 2013). z_s is the harmonic mean of the
 * nearest reflector's distance over 5 x 5 pixels of the object. All lengths are relative to the
 * size of a pixel at the receiver, so that the scene's extent does not matter: the least z of 8 px
 * at 512 rows leaves the error of 2 % of the scene within 2 % (a room, 4 to 256 samples). Pixel
 * sizes are not stretched by the surface's slant, which would cost a third more error.
 *
 * The widths suit paths that are noisy behind the first bounce. Where only the first direction is
 * random, the pattern's noise is so fine that mu = 0.7 has a fifth less error; where half of the
 * samples are black at random, mu = 0.6 has a third more.
 *
 * Under INDIRECT_FILTER_ADAPTIVE widths are those of indirect_adaptive.h: mu(n) is the plan's
 * adaptive.mu, whatever the samples, and the cap falls with its cube root. */
#include "server/reconstruct/indirect/indirect_field.h"

struct indirect_rule {
    float bandwidth;         /* mu(n) / mu */
    float least_px, most_px; /* of beta; of the blend's widest */
    float ratio;             /* of the blend's next narrower width to a width: below 1; else 0 */
    float near_px;           /* least z */
    float samples;           /* n, by which mu and the cap scale; 0: they do not */
    float off_px;            /* how far neighbours may be off the tangent plane, and beta / 2 */
    /* Of the filter that smooths the blend's decisions and squared errors; 0: neither is needed. */
    float smooth_min_px, smooth_max_px;
};

/* Returns the plan's rule. The filter's members are 0 for INDIRECT_FILTER_NONE. */
struct indirect_rule indirect_rule_of(const struct plan *plan);

/* Returns ratio^(1/degree), by which widths shrink as samples grow, for a ratio above 0 and a
 * degree of 2 or more. It uses Newton's method from above instead of the C library's powers, whose
 * bits depend on the CPU. */
float indirect_root(float ratio, int degree);

/* Returns how far a filter of at most that beta reads. */
int32_t indirect_reach_px(float most_px);

/* Computes beta in scene units for the field's pixels in `rect`; 0 where nothing was measured.
 * `counts`, an array of the neighbourhood, holds each pixel's number of samples; NULL: the
 * plan's. */
void indirect_widths(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                     const struct indirect_neighbourhood *around, const float *counts,
                     struct rect rect, float *beta);

/* Sets the field's widths in `rect` to clamp(beta, least_px, most_px) * scale. */
void indirect_set_widths(const struct indirect_rule *rule, struct indirect_neighbourhood *around,
                         struct rect rect, const float *beta, float scale);
