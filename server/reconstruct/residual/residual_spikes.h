#pragma once
/* Spikes of paths' light (patch/spike_limits.h): one half of a pixel's samples has many times what
 * the other half and the pixels around have. The passes would make a spot of each, as no pixel is
 * like it. What it has beyond its limit is taken out before them, and added after them, spread over
 * pixels with like features, as far as there are enough to tell what light they stand for
 * (docs/reconstruction.md, Residual spikes). */
#include "server/reconstruct/residual/residual_field.h"

/* How much farther than the spread limits read, and what halves agree on. */
#define RESIDUAL_SPIKES_LIMIT_PX 24

struct residual_spikes {
    const float *excess; /* 3 planes for each component: what is to be added to the pixel's mean;
                            NULL: nothing */
    struct scratch *scratch; /* borrowed */
    float *memory;           /* owned; taken from there */
};

/* Takes spikes out of the field's halves, before the first pass, and spreads them
 * over `area`, in the patch's own coordinates. ERR_MEMORY. */
int residual_spikes_take(struct residual_field *field, struct rect area,
                         struct residual_spikes *out);
void residual_spikes_fini(struct residual_spikes *s);
