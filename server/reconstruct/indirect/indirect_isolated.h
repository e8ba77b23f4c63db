#pragma once
/* Indirect light of isolated pixels: mouldings, leaves, all that is finer than pixels are. Filters
 * that walk along rows and columns meet no second pixel of their surface there and leave the noise
 * of a pixel's few rays.
 *
 * Isolated is a pixel with at most one of its four neighbours on its surface. It takes the mean
 * over a round window of what bounce rays brought: of its own surface, wherever that lies in the
 * window, and, as long as those rays are fewer than INDIRECT_ISOLATED_RAYS, of others that face
 * about the same way and lie about as far. What others bring is wrong where light changes from one
 * facet to the next; it fades as samples grow, and is gone when the surface's own are enough. */
#include "server/reconstruct/indirect/indirect_field.h"

/* Rays whose mean shows little noise. */
#define INDIRECT_ISOLATED_RAYS 1000.0f

/* Of the pixels of `inner`, whose widths and reach are the field's: out[c] of isolated ones becomes
 * such a mean of in[c], an array of the patch; c < 3. `out` are arrays of the neighbourhood, which
 * knows all up to `reach` pixels around. Returns how many were isolated. */
uint64_t indirect_isolated_fill(const struct plan *plan, const struct patch *patch,
                                const struct indirect_neighbourhood *around, struct rect inner,
                                int32_t reach, const float *const *in, float *const *out);
