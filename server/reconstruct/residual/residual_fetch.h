#pragma once
/* Finds what another frame's samples say of the points that a patch shows. */
#include "server/reconstruct/residual/residual_history.h"

/* What one frame has for the pixels of a patch, row by row. */
struct residual_fetched {
    float *share; /* how much of what the frame has there is of the same surface, 0 .. 1 */
    float *taps;  /* sum of their squared weights, over the square of the sum */
    float *rest;  /* the same for the rest, whose lobes must look the same way, too */
    float (*half[2])[RESIDUAL_HISTORY_LIGHT]; /* where there is a share: R, G, B of components as in
                                                 residual_light */
    float *noise[RESIDUAL_COMPONENTS]; /* squared difference of the halves' guides, as single pixels
                                          have it */
};

/* The frames from the patch's own to the other one: their plans and how they move. */
struct residual_way {
    uint32_t steps;
    uint32_t view; /* enum plan_view, of all frames */
    enum motion_side side;
    const struct plan *plans[LIMIT_TEMPORAL_FRAMES + 1];
    const struct motion
        *motions[LIMIT_TEMPORAL_FRAMES + 1]; /* NULL: nothing but the camera moves */
};

/* Finds the patch's pixels in which, and in those beside which, nothing has moved: all samples that
 * the other frame has of them are as good as their own. `work` has as many bytes as `still`. */
void residual_find_still(const struct residual_history *from, const struct residual_way *way,
                         const struct patch *patch, uint8_t *work, uint8_t *still);

/* Fetches for all pixels of the patch, whose features the field has. `still` is of the same frame.
 */
void residual_fetch(const struct residual_history *from, const struct residual_way *way,
                    const struct patch *patch, const struct residual_features *features,
                    const uint8_t *still, const struct residual_fetched *out);
