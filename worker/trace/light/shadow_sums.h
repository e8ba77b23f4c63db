#pragma once
/* A light's results in sixteen pixels while its strata are traced. */
#include "worker/shade/lanes.h"

/* Strata that are sampled, traced and summed up together: nine of a pixel stay in the first-level
 * cache, and Embree is called back to back. */
#define SHADOW_BATCH 9

struct shadow_sums {
    _Alignas(LANES_ALIGN) float irradiance[LANES]; /* of finished rows of strata */
    _Alignas(LANES_ALIGN) float row[LANES];        /* of the row at hand: short sums round less */
    _Alignas(LANES_ALIGN) float least[LANES];      /* blocked t */
    _Alignas(LANES_ALIGN) float most[LANES];
    _Alignas(LANES_ALIGN) int32_t seen[LANES]; /* bits of strata, until a byte is whole */
    struct lanes_mask blocked;                 /* any stratum */
};
