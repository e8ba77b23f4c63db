#include "server/reconstruct/lighting/lens_cull.h"

#include <math.h>

#include "server/reconstruct/lens/lens_cells.h"
#include "server/reconstruct/lens/lens_residual.h"

/* Samples lie anywhere in their pixels, are looked for by corners of those, and share light. */
#define PLACE_PX 3
#define ROUNDING 0.999f /* of slopes between layers */

static void add_layer(struct lens_cull *c, uint32_t layer, uint32_t l)
{
    float low, high;
    lens_layer_slopes(layer, &low, &high);
    const bool focus = layer == LENS_FOCUS;
    const float least = focus ? 0.0f : ROUNDING * fminf(fabsf(low), fabsf(high));
    const float most = fminf(fmaxf(fabsf(low), fabsf(high)), LENS_SLOPE_MAX);
    const int32_t around = focus ? LENS_FOCUS_REACH_PX : lens_cells_around_px(layer, l);
    const int32_t reach = around + PLACE_PX + (int32_t)ceilf(most); /* of pixels */
    c->around[layer] = (float)(around + PLACE_PX);
    for (int32_t d = 0; d <= reach && d <= LENS_CULL_PX; d++)
        c->least[d] = fminf(c->least[d], least);
}

/* Other filters read all that they see. Samples of `near` tell of errors, too (lens_second_set.h).
 */
void lens_cull_init(const struct plan *plan, struct rect block, struct rect seen,
                    struct lens_cull *out)
{
    const bool sheared = plan->lens_filter == LENS_FILTER_SHEARED;
    const struct rect wide = rect_grow(block, lens_residual_reach_px(plan));
    *out = (struct lens_cull){.near = sheared ? rect_intersect(wide, seen) : seen};
    for (int32_t d = 0; d <= LENS_CULL_PX; d++) out->least[d] = INFINITY;
    for (uint32_t k = 0; k < LENS_LAYERS; k++) add_layer(out, k, plan->lens_strata_per_axis);
    out->least[0] = 0.0f;
}

int32_t lens_cull_reach_px(const struct lens_cull *c, float most)
{
    int32_t d = 0;
    while (d < LENS_CULL_PX && c->least[d + 1] <= most) d++;
    return d;
}

void lens_cull_row(const struct lens_cull *c, int32_t x, int32_t down, uint32_t count, float *least)
{
    for (uint32_t i = 0; i < count; i++) {
        const int32_t across = lens_cull_distance(x + (int32_t)i, c->near.x0, c->near.x1);
        const int32_t d = across > down ? across : down;
        least[i] = c->least[d < LENS_CULL_PX ? d : LENS_CULL_PX];
    }
}
