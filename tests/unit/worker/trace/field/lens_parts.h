#pragma once
/* What a lens sample brings, in parts. */
#include "proto/shared_exponent.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

enum { SIDE = 48, L = 3, N = L * L };

/* Of a sample: left radiance and own light times albedo. */
static inline void parts_of(const struct traced *t, uint32_t k, size_t i, float left[3],
                            float light[3])
{
    float albedo[3];
    shared_exponent_unpack(samples_u32(t->samples, PLANE_LENS_ALBEDO, k)[i], SHARED_EXPONENT_9,
                           albedo);
    shared_exponent_unpack(samples_u32(t->samples, PLANE_LENS_OWN_LIGHT, k)[i], SHARED_EXPONENT_8,
                           light);
    for (uint32_t c = 0; c < 3; c++) {
        left[c] = samples_f32(t->samples, PLANE_LENS_RADIANCE, k * 3 + c)[i];
        light[c] *= 0.25f * albedo[c];
    }
}

static inline bool is_black(const float light[3])
{
    return !(light[0] + light[1] + light[2] > 0.0f);
}
