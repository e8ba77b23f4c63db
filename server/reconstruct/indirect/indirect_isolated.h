#pragma once
/* Indirect light of isolated pixels. Mouldings and leaves are finer than pixels, so that filters
 * along rows and columns find no second pixel of their surface and keep the noise of a pixel's few
 * rays.
 *
 * A pixel is isolated if at most one of its four neighbours is on its surface. It takes a mean over
 * a round window. Pixels of its own surface count wherever they lie in the window. While their rays
 * are fewer than INDIRECT_ISOLATED_RAYS, other surfaces that face about the same way and lie about
 * as far away count, too. Their part is wrong where light changes from facet to facet; it fades as
 * samples grow and ends when the surface's own rays suffice. */
#include "server/reconstruct/indirect/indirect_field.h"

/* The rays whose mean shows little noise. */
#define INDIRECT_ISOLATED_RAYS 1000.0f

/* Replaces out[c] of the isolated pixels of `inner` by such a mean of in[c], an array of the patch;
 * c < 3. Widths and reach are the field's. `out` are arrays of the neighbourhood, which covers
 * `reach` pixels around. Returns the number of isolated pixels. */
uint64_t indirect_isolated_fill(const struct plan *plan, const struct patch *patch,
                                const struct indirect_neighbourhood *around, struct rect inner,
                                int32_t reach, const float *const *in, float *const *out);
