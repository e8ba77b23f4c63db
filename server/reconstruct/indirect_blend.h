#pragma once
/* The variance-aware blend (filters.md section 3): rule B at four widths, each half of the one
 * before; where the next wider one differs by more than noise explains, the narrower stands.
 *
 *   V_k = smoothed (E - F_3)^2 / (4 pi sigma_k^2),  D_k = smoothed (F_k - F_k-1)^2
 *   out = F_3;  for k = 3, 2, 1: out = F_k-1 + clamp(1 - c V_k / D_k, 0, 1) (out - F_k-1)
 *
 * Differences are relative to F_0 and summed over the channels: one decision for all of them,
 * whatever their units. Of means over half of the samples it sees twice the noise. */
#include "server/reconstruct/indirect_pass.h"

/* Spare arrays of a place that blends `count` channels: the first `count` hold them and become the
 * result, the next one becomes its width in scene units. */
uint32_t indirect_blend_spares(uint32_t count);

/* Blends `count` channels over `rect`, of a place that reaches indirect_halo_px around it. */
void indirect_blend(const struct plan *plan, const struct indirect_rule *rule,
                    const struct indirect_kernels *kernels, struct indirect_place *place,
                    struct rect rect, uint32_t count);
