#pragma once
/* Emitting triangles for tests of what groups them. */
#include <math.h>

#include "tests/random.h"
#include "worker/scene/emitter_groups.h"

/* A triangle around `at`, facing along the unit `normal`. */
static inline struct emitter_shape shape_at(const float at[3], const float normal[3], float size,
                                            double power)
{
    struct emitter_shape s = {.power = power};
    const int least = fabsf(normal[0]) < 0.6f ? 0 : 1;
    float side[3] = {0}, up[3];
    side[least] = 1.0f;
    for (int k = 0; k < 3; k++) side[k] -= normal[least] * normal[k];
    for (int k = 0; k < 3; k++)
        up[k] = normal[(k + 1) % 3] * side[(k + 2) % 3] - normal[(k + 2) % 3] * side[(k + 1) % 3];
    for (int k = 0; k < 3; k++) {
        s.corner[0][k] = at[k];
        s.corner[1][k] = at[k] + size * side[k];
        s.corner[2][k] = at[k] + size * up[k];
        s.normal[k] = normal[k];
    }
    return s;
}

static inline void random_normal(struct random *r, float out[3])
{
    float squared;
    do {
        squared = 0.0f;
        for (int k = 0; k < 3; k++) {
            out[k] = 2.0f * random_unit(r) - 1.0f;
            squared += out[k] * out[k];
        }
    } while (squared > 1.0f || squared < 0.01f);
    for (int k = 0; k < 3; k++) out[k] /= sqrtf(squared);
}
