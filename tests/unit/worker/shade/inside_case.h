#pragma once
/* The inside of a glass volume, on which layers of its outside have no bearing. */
#include "tests/unit/unit.h"
#include "worker/shade/bsdf.h"

static const struct bsdf inside_glass = {.model = BSDF_GLTF,
                                         .alpha_u = 0.3f,
                                         .alpha_v = 0.3f,
                                         .base_color = {1, 1, 1},
                                         .transmission = 1,
                                         .specular = 1,
                                         .specular_f0 = {0.04f, 0.04f, 0.04f},
                                         .ior = 1 / 1.5f,
                                         .inside = true};

static inline void expect_as_inside_glass(const struct bsdf *layered)
{
    const float wo[3] = {0.1f, 0, 0.995f}, wi[3] = {-0.1f, 0, 0.995f};
    struct bsdf_value a, b;
    bsdf_evaluate(&inside_glass, wo, wi, &a);
    bsdf_evaluate(layered, wo, wi, &b);
    assert_memory_equal(&a, &b, sizeof a);
}
