#pragma once
/* Reads textures where sixteen rays met one mesh. All texels are found first (place_texels of
 * hit_kernels), so that those out of cache are fetched together. Then each lane blends its four. */
#include "worker/scene/material/texture.h"
#include "worker/shade/lanes.h"

struct texel_lanes {
    _Alignas(LANES_ALIGN) int32_t at[4][LANES]; /* upper left, right; lower left, right */
    _Alignas(LANES_ALIGN) float across[LANES];  /* how far the right ones count */
    _Alignas(LANES_ALIGN) float down[LANES];    /* and the lower ones */
};

/* Computes texture_sample's colour for lane i. */
static inline void texels_blend(const struct texture *t, const struct texel_lanes *p, int i,
                                float out[4])
{
    const size_t at[4] = {(size_t)p->at[0][i], (size_t)p->at[1][i], (size_t)p->at[2][i],
                          (size_t)p->at[3][i]};
    texture_blend(t, at, p->across[i], p->down[i], out);
}
