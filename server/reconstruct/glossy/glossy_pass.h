#pragma once
/* One run of a filter that compares lobes over a block, along x and then along y. Each pixel has
 * the rule of its number of rays. */
#include "server/reconstruct/glossy/glossy_field.h"

struct glossy_pass {
    const struct plan *plan;
    const struct patch *patch; /* tells how many rays pixels have */
    float width;               /* times that of the rule: at most 1 */
    bool smooth;               /* not the filter, but what smooths its squared errors */
};

/* Returns how many pixels to both sides a pass reads, which is the reach of the fewest rays. */
int32_t glossy_pass_reach(const struct glossy_pass *pass);

/* Filters `count` channels of the neighbourhood, `in`, over `rect`. `between` holds the result of
 * the first line and is neither `in` nor `out`, which may be the same. The neighbourhood's rules
 * become the pass's. */
void glossy_pass_run(const struct glossy_pass *pass, struct glossy_neighbourhood *around,
                     struct rect rect, uint32_t count, float *const *in, float *const *between,
                     float *const *out);
