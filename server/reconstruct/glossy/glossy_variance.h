#pragma once
/* Estimates variances of filtered light of glossy lobes from the mean over half of the rays, by the
 * formula of indirect_variance.h, with F a quotient of light and weights. */
#include "server/reconstruct/glossy/glossy_pass.h"

struct glossy_variance {
    const struct plan *plan;
    const struct patch *patch;
    struct glossy_neighbourhood *around; /* channels: what was measured, all and halves */
    bool filtered;                       /* around->wide is F of them; else nothing was filtered */
};

/* Returns how many pixels around `rect` F must be known for. */
int32_t glossy_variance_reach(const struct plan *plan);

/* Estimates variances over `rect`, from F over `wide`, and writes variance[c] of the patch's pixels
 * there with a filtered lobe. Overwrites the neighbourhood's channels and rules. */
void glossy_variance_find(const struct glossy_variance *s, struct rect wide, struct rect rect,
                          float *const variance[3]);
