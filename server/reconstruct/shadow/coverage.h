#pragma once
/* Tables of a sample's weight by its position on the light: I(y) / cov(y) (docs/reconstruction.md,
 * Sample weights). cov is the share of sheared samples that stay on the light; dividing by it keeps
 * wide penumbrae from ringing. Lengths are fractions of the half-side, so that both axes of a
 * rectangle share one table. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "server/reconstruct/simd/gaussian.h"

#define COVERAGE_RHO_MIN 1e-3f /* below, every sample stays on the light */
#define COVERAGE_ALL_MIN 1e-6f /* with rho beyond any use, as near to 1 everywhere */
#define COVERAGE_MIN     0.05f /* least divisor; true values at |y| <= 1 are above 0.4 */

#define COVERAGE_STEPS 17 /* of rho = |eta| sigma_x, and of the root of delta */
#define COVERAGE_ROWS  (COVERAGE_STEPS * COVERAGE_STEPS)

/* The row of the largest rho and of delta 0, for pixels without a wedge. */
#define COVERAGE_WIDEST    ((COVERAGE_STEPS - 1) * COVERAGE_STEPS)
#define COVERAGE_DELTA_MAX 2.0f

struct coverage {
    uint32_t scale, window; /* as in struct shadow_field */
    uint32_t profile;       /* enum light_profile */
    float rho_max;
    bool ready[COVERAGE_ROWS]; /* rows are computed when first needed */
    float *weights;            /* owned; as in struct shadow_field */
};

/* Returns r, the nodes along a light's side, for strata x strata samples. */
uint32_t coverage_scale(uint32_t strata);

/* Creates weights for l strata an axis and rho up to rho_max. ERR_MEMORY. */
int coverage_create(uint32_t strata, uint32_t profile, float rho_max, struct coverage *out);
void coverage_fini(struct coverage *coverage);

/* Returns the row of the nearest rho >= 0 and delta in [0, 2]; per_rho_max is 1 / rho_max. */
static inline int32_t coverage_row(float per_rho_max, float rho, float delta)
{
    const float steps = COVERAGE_STEPS - 1;
    const float share = rho * per_rho_max, r = share < 1.0f ? share : 1.0f;
    const float d = delta < COVERAGE_DELTA_MAX ? sqrtf(delta / COVERAGE_DELTA_MAX) : 1.0f;
    const int32_t i = (int32_t)(r * steps + 0.5f), j = (int32_t)(d * steps + 0.5f);
    return i * COVERAGE_STEPS + j;
}

/* The numbers of cov that all positions on the light share. Loops over positions vectorise: where
 * every sample stays on the light, share is 0 and rest 1. */
struct coverage_shear {
    float reach, inverse; /* 1 + delta; 1 / rho or 0 */
    float all, rest;
};

static inline struct coverage_shear coverage_shear_of(float rho, float delta)
{
    struct coverage_shear s = {.reach = 1.0f + delta};
    s.inverse = rho < COVERAGE_RHO_MIN ? 0.0f : 1.0f / rho;
    s.all = 2.0f * gaussian_phi(s.reach * s.inverse) - 1.0f;
    if (s.all > COVERAGE_ALL_MIN) return s;
    return (struct coverage_shear){.reach = s.reach, .all = 1.0f, .rest = 1.0f};
}

/* Returns cov at y half-sides. */
static inline float coverage_at(const struct coverage_shear *s, float y)
{
    const float stays = gaussian_phi((s->reach - y) * s->inverse) +
                        gaussian_phi((s->reach + y) * s->inverse) - 1.0f;
    const float share = (stays + s->rest) / s->all;
    return share > COVERAGE_MIN ? share : COVERAGE_MIN;
}

/* Computes the weights of a row unless they are there. */
void coverage_need(struct coverage *coverage, int32_t row);
