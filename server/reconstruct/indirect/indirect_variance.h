#pragma once
/* Squared standard errors of filtered indirect light, from what half of the samples measured:
 *
 *   S (F(half) - F(mean))^2 + max(0, S (F - F')^2 - S (noise of F - F')^2) / (1 - r^2)^2
 *
 * F is the filter, F' the same at r times its width: where light is smooth, bias grows with the
 * square of the width. A half is off the mean by as much as the mean is off the truth. Where F and
 * F' differ by more than their noise, of which the halves tell again, the filter is biased. S is a
 * mean over the surface around. */
#include "server/reconstruct/indirect/indirect_pass.h"

/* Squares to find: in spares of the neighbourhood. */
struct indirect_variance {
    const struct plan *plan;
    const struct indirect_rule *rule;
    const struct indirect_kernels *kernels;
    struct indirect_neighbourhood *around;
    uint32_t mean, half;  /* F of three channels, and of their halves */
    uint32_t width;       /* of F, in scene units */
    float ratio;          /* r < 1 */
    uint32_t narrower[6]; /* F' of the same; in rules A and B their own, which hold the channels as
                             they were measured and become F' */
    uint32_t own;         /* the first of INDIRECT_VARIANCE_SPARES that it may use */
};

#define INDIRECT_VARIANCE_SPARES 13

/* Pixels around `rect` that F must be known for. */
int32_t indirect_variance_reach(const struct indirect_rule *rule);

/* Finds the variances over `rect`, from F over `wide`. Widths of the neighbourhood are overwritten.
 */
void indirect_variance_find(const struct indirect_variance *s, struct rect wide, struct rect rect);

/* The result: of channel c < 3. */
static inline const float *indirect_variance_of(const struct indirect_variance *s, uint32_t c)
{
    return indirect_neighbourhood_spare(s->around, s->own + c);
}
