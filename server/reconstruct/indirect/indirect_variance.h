#pragma once
/* Estimates variances of filtered indirect light from the mean over half of the samples:
 *
 *   S (F(half) - F(mean))^2 + max(0, S (F - F')^2 - S (noise of F - F')^2) / (1 - r^2)^2
 *
 * F is the filter, F' the same at r times its width, and S a mean over the surface around. The
 * first term is noise: a half is off the mean by as much as the mean is off the truth. The second
 * is bias: where F and F' differ by more than their noise, which the halves tell again, the filter
 * is biased. Where light is smooth, bias grows with the square of the width. */
#include "server/reconstruct/indirect/indirect_pass.h"

/* A call. The indices are those of spares of the neighbourhood. */
struct indirect_variance {
    const struct plan *plan;
    const struct indirect_rule *rule;
    const struct indirect_kernels *kernels;
    struct indirect_neighbourhood *around;
    uint32_t mean, half;  /* F of three channels, and F of their halves */
    uint32_t width;       /* of F, in scene units */
    float ratio;          /* r < 1 */
    uint32_t narrower[6]; /* F' of the same. In rules A and B these spares hold the channels as
                             measured and become F'. */
    uint32_t own;         /* the first of INDIRECT_VARIANCE_SPARES spares for its own use */
};

#define INDIRECT_VARIANCE_SPARES 13

/* Returns how many pixels around `rect` F must be known for. */
int32_t indirect_variance_reach(const struct indirect_rule *rule);

/* Estimates variances over `rect`, from F over `wide`. Overwrites widths of the neighbourhood. */
void indirect_variance_find(const struct indirect_variance *s, struct rect wide, struct rect rect);

/* Returns the result for channel c < 3. */
static inline const float *indirect_variance_of(const struct indirect_variance *s, uint32_t c)
{
    return indirect_neighbourhood_spare(s->around, s->own + c);
}
