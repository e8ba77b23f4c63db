#pragma once
/* A light's results in sixteen pixels while its strata are traced. */
#include "worker/trace/lanes.h"

struct shadow_sums {
    _Alignas(LANES_ALIGN) float irradiance[LANES]; /* of finished rows of strata */
    _Alignas(LANES_ALIGN) float row[LANES];        /* of the row at hand: short sums round less */
    _Alignas(LANES_ALIGN) float least[LANES];      /* blocked t */
    _Alignas(LANES_ALIGN) float most[LANES];
    _Alignas(LANES_ALIGN) int32_t seen[LANES]; /* bits of up to eight strata */
    struct lanes_mask blocked;                 /* any stratum */
};
