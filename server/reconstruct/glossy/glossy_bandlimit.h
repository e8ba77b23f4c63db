#pragma once
/* The filter of glossy lobes by their bandlimits, as glossy.h describes it. */
#include "server/reconstruct/patch/patch.h"

int32_t glossy_bandlimit_halo_px(const struct plan *plan);

/* Filters as glossy_filter_with_error does, which has checked the arguments. variance may be NULL.
 * *filtered becomes the number of pixels with a lobe. */
int glossy_bandlimit(const struct plan *plan, const struct patch *patch, struct rect inner,
                     float *const out[3], float *const variance[3], uint64_t *filtered);
