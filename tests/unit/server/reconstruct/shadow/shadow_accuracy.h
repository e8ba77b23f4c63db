#pragma once
/* The shadow filters' error on a scene of formulas, over penumbra pixels and relative to the
 * brightest unshadowed irradiance, and brute-force 4D sheared filtering as the truth for the
 * factorisation. */
#include <stdbool.h>

#include "server/reconstruct/shadow/shadow.h"
#include "server/reconstruct/shadow/sheared.h"
#include "server/reconstruct/shadow/strata.h"
#include "server/reconstruct/simd/gaussian.h"
#include "tests/unit/server/reconstruct/shadow/shadow_scene.h"
#include "tests/unit/unit.h"

struct shadow_truth {
    int32_t width, height;
    float *irradiance, *seen;
    float brightest;
    size_t penumbra; /* pixels seen between 2 % and 98 % */
};

static inline bool truth_in_penumbra(const struct shadow_truth *t, size_t i)
{
    return t->seen[i] > 0.02f && t->seen[i] < 0.98f;
}

void truth_fini(struct shadow_truth *t);

/* Light 0's true irradiance. */
void truth_init(struct shadow_truth *t, const struct shadow_scene *s);

double truth_rmse(const struct shadow_truth *t, const float *a, const float *b);

/* Samples of the whole picture at l x l strata, irradiance included. Owned by the caller. */
struct patch *accuracy_patch(struct shadow_scene *s, uint32_t l);

/* The filtered irradiance of the whole picture, block by block. Owned by the caller. */
float *accuracy_filter(struct shadow_scene *s, const struct patch *patch, enum shadow_filter filter,
                       int32_t block_px, struct shadow_statistics *statistics);

struct brute {
    const struct receiver_light *light;
    const struct receivers *receivers;
    const struct patch *patch; /* the receivers' rect is the patch's, grown */
    float rho[2], delta[2];
};

/* The picture by brute force; `base` where there is no wedge, and outside penumbrae, which
 * truth_rmse leaves out. Owned by the caller. */
float *accuracy_brute(struct shadow_scene *s, const struct patch *patch,
                      const struct shadow_truth *truth, const float *base);
