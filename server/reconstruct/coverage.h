#pragma once
/* The weight of a sample by its place on the light: I(y) / cov(y) of filters.md section 2, looked
 * up. Of samples sheared on to the light, cov is the share that stays there; dividing by it keeps
 * wide penumbrae from ringing. Lengths are fractions of the half-side, so that both axes of a
 * rectangle share one table. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define COVERAGE_STEPS 17 /* of rho = |eta| sigma_x, and of the root of delta */
#define COVERAGE_ROWS  (COVERAGE_STEPS * COVERAGE_STEPS)

/* The row of the largest rho and delta 0: of what has no wedge. */
#define COVERAGE_WIDEST     ((COVERAGE_STEPS - 1) * COVERAGE_STEPS)
#define COVERAGE_DELTA_MOST 2.0f

struct coverage {
    uint32_t scale, window; /* as in struct shadow_field */
    uint32_t profile;       /* enum light_profile */
    float rho_most;
    bool ready[COVERAGE_ROWS]; /* rows are computed when first needed */
    float *weights;            /* owned; as in struct shadow_field */
};

/* Weights for l strata an axis and rho up to rho_most. ERR_MEMORY. */
int coverage_create(uint32_t strata, uint32_t profile, float rho_most, struct coverage *out);
void coverage_fini(struct coverage *coverage);

/* The row of the nearest rho >= 0 and delta in [0, 2]. */
static inline int32_t coverage_row(float rho_most, float rho, float delta)
{
    const float steps = COVERAGE_STEPS - 1;
    const float r = rho < rho_most ? rho / rho_most : 1.0f;
    const float d = delta < COVERAGE_DELTA_MOST ? sqrtf(delta / COVERAGE_DELTA_MOST) : 1.0f;
    const int32_t i = (int32_t)(r * steps + 0.5f), j = (int32_t)(d * steps + 0.5f);
    return i * COVERAGE_STEPS + j;
}

/* Computes the weights of a row, unless they are there. */
void coverage_need(struct coverage *coverage, int32_t row);
