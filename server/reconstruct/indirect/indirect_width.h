#pragma once
/* How wide the filters of indirect light are (docs/reconstruction.md, Indirect widths):
 *
 *   beta = mu clamp((2 / 2.8) max(z_s, least z) / mu(n), 0.6 px, cap(n))
 *
 * 2.8 is the bandlimit of a clamped cosine (Mehta et al. 2013), z_s the harmonic mean over 5 x 5
 * pixels of the object of the nearest reflector's distance. All is relative to the size of a pixel
 * at the receiver, so that no scene's extent comes in: the least z of 8 px at 512 lines leaves the
 * error of 2 % of the scene within 2 % (a room, 4 to 256 samples). Pixel sizes are not stretched by
 * the surface's slant: that costs a third more error.
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
    float samples;           /* n, which mu and the cap go by; 0: they do not */
    float off_px;            /* how far neighbours may be off the tangent plane, and beta / 2 */
    /* of what smooths the blend's decisions and the squares of errors; 0: neither is wanted */
    float smooth_least_px, smooth_most_px;
};

/* The plan's rule; of filters all 0 for INDIRECT_FILTER_NONE. */
struct indirect_rule indirect_rule_of(const struct plan *plan);

/* ratio^(1/degree) of a ratio above 0, degree 2 or more: how widths shrink as samples grow. By
 * Newton from above, without the C library's powers, whose bits hang on the CPU. */
float indirect_root(float ratio, int degree);

/* How far a filter of at most that beta looks. */
int32_t indirect_reach_px(float most_px);

/* beta in scene units of the field's pixels in `rect`; 0: nothing was measured. `counts`, an array
 * of the neighbourhood, says how many samples each pixel has; NULL: as many as the plan says. */
void indirect_widths(const struct indirect_rule *rule, const struct indirect_kernels *kernels,
                     const struct indirect_neighbourhood *around, const float *counts,
                     struct rect rect, float *beta);

/* Sets the field's widths in `rect` to clamp(beta, least_px, most_px) * scale. */
void indirect_set_widths(const struct indirect_rule *rule, struct indirect_neighbourhood *around,
                         struct rect rect, const float *beta, float scale);
