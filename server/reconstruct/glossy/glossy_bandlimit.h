#pragma once
/* The filter of glossy lobes by their bandlimits: glossy.h says how. */
#include "server/reconstruct/patch/patch.h"

int32_t glossy_bandlimit_halo_px(const struct plan *plan);

/* As glossy_filter_with_error, whose arguments it has checked; variance may be NULL; *filtered:
 * pixels with a lobe. */
int glossy_bandlimit(const struct plan *plan, const struct patch *patch, struct rect inner,
                     float *const out[3], float *const variance[3], uint64_t *filtered);
