#pragma once
/* Sample buffers with numbers that their planes allow, for tests to pack and to damage. */
#include <stdlib.h>

#include "proto/half.h"
#include "proto/samples.h"
#include "tests/unit/proto/plan_case.h"

static inline uint32_t samples_case_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 33);
}

static inline uint16_t samples_case_half(uint64_t *state)
{
    return (uint16_t)(samples_case_random(state) % 0x7c00u); /* finite, not negative */
}

static inline void samples_case_plane(struct samples *s, enum plane_id plane, uint64_t *state)
{
    const struct samples_plane *row = samples_plane(plane);
    const size_t area = (size_t)s->layout.width_px * (size_t)s->layout.height_px;
    for (uint32_t c = 0; c < s->layout.components[plane]; c++)
        for (size_t i = 0; i < area; i++) {
            if (row->type == SAMPLES_F32)
                samples_f32(s, plane, c)[i] = (float)samples_case_random(state) * 1e-6f;
            else if (row->values == SAMPLES_ID)
                samples_u32(s, plane, c)[i] = 1 + samples_case_random(state) % 100;
            else if (row->type == SAMPLES_U32) /* exponents below 128 */
                samples_u32(s, plane, c)[i] = samples_case_random(state);
            else if (plane == PLANE_SUB_DEPTH && samples_case_random(state) % 4 == 0)
                samples_u16(s, plane, c)[i] = half_from_float(SUB_DEPTH_MISS);
            else
                samples_u16(s, plane, c)[i] = samples_case_half(state);
        }
}

static inline void samples_case_light(struct samples *s, uint32_t k, uint64_t *state)
{
    const size_t area = (size_t)s->layout.width_px * (size_t)s->layout.height_px;
    const uint32_t planes = s->layout.light_planes[k], strata = s->layout.light_strata[k];
    for (size_t i = 0; i < area; i++) {
        if (planes & 1u << LIGHT_PLANE_IRRADIANCE)
            samples_light_irradiance(s, k)[i] = (float)samples_case_random(state) * 1e-9f;
        if (planes & 1u << LIGHT_PLANE_VISIBILITY)
            for (uint32_t stratum = 0; stratum < strata; stratum++)
                if (samples_case_random(state) & 1)
                    samples_light_visibility(s, k, stratum / 8)[i] |= (uint8_t)(1u << stratum % 8);
        if (planes & 1u << LIGHT_PLANE_SLOPES) {
            const uint16_t a = samples_case_half(state), b = samples_case_half(state);
            samples_light_slope(s, k, 0)[i] = a < b ? a : b;
            samples_light_slope(s, k, 1)[i] = a < b ? b : a;
        }
        if (planes & 1u << LIGHT_PLANE_DIFFUSE_WEIGHT)
            samples_light_weight(s, k)[i] = samples_case_half(state);
    }
}

/* Fills the planes in `planes` and the lights' planes in `light_planes`; the others stay zero. */
static inline void samples_case_fill(struct samples *s, uint64_t planes, uint32_t lights,
                                     uint64_t seed)
{
    uint64_t state = seed * 2 + 1;
    for (uint32_t p = 0; p < PLANE_ID_COUNT; p++)
        if (s->layout.planes & planes & UINT64_C(1) << p) samples_case_plane(s, p, &state);
    for (uint32_t k = 0; k < s->layout.light_count; k++)
        if (lights >> k & 1) samples_case_light(s, k, &state);
}
