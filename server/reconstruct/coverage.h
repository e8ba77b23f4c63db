#pragma once
/* The weight of a sample by its place on the light: I(y) / cov(y) of filters.md section 2, looked
 * up. Of samples sheared on to the light, cov is the share that stays there; dividing by it keeps
 * wide penumbrae from ringing. Lengths are fractions of the half-side, so that both axes of a
 * rectangle share one table. */
#include <stdbool.h>
#include <stdint.h>

#define COVERAGE_STEPS 17 /* of rho = |eta| sigma_x, and of the root of delta */
#define COVERAGE_ROWS  (COVERAGE_STEPS * COVERAGE_STEPS)

struct coverage {
    uint32_t scale, window; /* as in struct shadow_field */
    uint32_t profile;       /* enum light_profile */
    float rho_most;
    bool ready[COVERAGE_ROWS]; /* rows are computed when first asked for */
    float *weights;            /* owned; as in struct shadow_field */
};

/* Weights for l strata an axis and rho up to rho_most. ERR_MEMORY. */
int coverage_create(uint32_t strata, uint32_t profile, float rho_most, struct coverage *out);
void coverage_fini(struct coverage *coverage);

/* The row of the nearest rho >= 0 and delta in [0, 2]. */
int32_t coverage_row(struct coverage *coverage, float rho, float delta);
