#include "server/reconstruct/indirect/occlusion.h"

int occlusion_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                     float *visibility, float *width_px, struct indirect_statistics *statistics)
{
    const float *const in[] = {patch->ambient_visibility};
    float *const out[] = {visibility};
    struct patch around = *patch;
    if (patch->ambient_distance_min) around.bounce_distance_min = patch->ambient_distance_min;
    return indirect_filter(plan, &around, inner, 1, in, out, width_px, statistics);
}
