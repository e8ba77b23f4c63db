#pragma once
/* Squared standard errors of filtered light of glossy lobes, from what half of the rays measured:
 * the formula of indirect_variance.h, with F a quotient of light and weights. */
#include "server/reconstruct/glossy/glossy_pass.h"

struct glossy_variance {
    const struct plan *plan;
    const struct patch *patch;
    struct glossy_neighbourhood *around; /* channels: what was measured, all and halves */
    bool filtered;                       /* around->wide is F of them; else nothing was filtered */
};

/* Pixels around `rect` that F must be known for. */
int32_t glossy_variance_reach(const struct plan *plan);

/* Finds the variances over `rect`, from F over `wide`, and writes variance[c] of the patch's pixels
 * there whose lobes take part. The neighbourhood's channels and rules are overwritten. */
void glossy_variance_find(const struct glossy_variance *s, struct rect wide, struct rect rect,
                          float *const variance[3]);
