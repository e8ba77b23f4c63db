#include "server/reconstruct/glossy/glossy_bandlimit.h"

#include "proto/samples.h"
#include "server/reconstruct/indirect/indirect.h"
#include "server/reconstruct/indirect/indirect_adaptive.h"

#define NEAR_MIN 1e-6f /* of length_unit / distance: as good as nothing met */

/* The plan as the filter of indirect light understands it. */
static struct plan as_indirect(const struct plan *plan)
{
    struct plan out = *plan;
    out.indirect_filter = INDIRECT_FILTER_CONSTANT;
    out.planes &= ~PLANE_BIT(INDIRECT_HALVES); /* diffuse light's, of which errors would be made */
    if (patch_knows_glossy_errors(plan))
        out.planes |= PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(BOUNCE_DISTANCE_MIN);
    return out;
}

int32_t glossy_bandlimit_halo_px(const struct plan *plan)
{
    const struct plan indirect = as_indirect(plan);
    return indirect_halo_px(&indirect);
}

/* Returns the reflector distance that gives rule A a lobe's width; 0 without a lobe. */
static float reflector_of(const struct plan *plan, const struct patch *patch, size_t i)
{
    const float near = patch->glossy_nearness[i], alpha = patch->glossy_alpha[i];
    if (!patch_is_glossy(patch, i)) return 0.0f;
    if (!(near * plan->length_unit > NEAR_MIN)) return BOUNCE_DISTANCE_NONE * plan->length_unit;
    const float exponent = 2.0f / (alpha * alpha) - 2.0f; /* alpha: at least a step of its plane */
    const struct indirect_bandlimit band =
        indirect_bandlimit_blinn_phong(exponent > 0.0f ? exponent : 0.0f);
    return INDIRECT_OMEGA_LAMBERT / (band.omega * near); /* rule A is made for that */
}

int glossy_bandlimit(const struct plan *plan, const struct patch *patch, struct rect inner,
                     float *const out[3], float *const variance[3], uint64_t *filtered)
{
    const struct plan indirect = as_indirect(plan);
    const size_t area = (size_t)rect_area(patch->rect);
    const float *const *in = (const float *const *)patch->glossy;
    struct indirect_statistics statistics = {0};
    struct patch lobes = *patch;
    lobes.bounces = patch->glossy_rays;
    lobes.bounce_distance_min =
        scratch_take(patch->scratch, area * sizeof *lobes.bounce_distance_min);
    if (!lobes.bounce_distance_min) return ERR_MEMORY;
    for (size_t i = 0; i < area; i++) lobes.bounce_distance_min[i] = reflector_of(plan, patch, i);
    struct indirect_error e = {.half = {NULL}};
    for (int c = 0; c < 3 && variance; c++) {
        e.half[c] = patch->glossy_half[c];
        e.variance[c] = variance[c];
    }
    const int error =
        variance ? indirect_filter_with_error(&indirect, &lobes, inner, 3, in, out, NULL, &e,
                                              &statistics)
                 : indirect_filter(&indirect, &lobes, inner, 3, in, out, NULL, &statistics);
    scratch_give(patch->scratch, lobes.bounce_distance_min);
    *filtered = statistics.pixels_filtered;
    return error;
}
