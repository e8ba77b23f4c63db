#pragma once
/* The filter of ambient occlusion: that of indirect light (indirect.h), by what the rays of all
 * surfaces met. Indirect light has no rays of black ones, and does not see theirs. */
#include "server/reconstruct/indirect/indirect.h"

/* Filters patch->ambient_visibility as indirect_filter does its channels. */
int occlusion_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                     float *visibility, float *width_px, struct indirect_statistics *statistics);
