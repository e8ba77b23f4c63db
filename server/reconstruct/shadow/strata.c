#include "server/reconstruct/shadow/strata.h"

#include "server/reconstruct/simd/inline.h"

void strata_jitters(const struct receiver_light *light, const int32_t *x, const int32_t *y,
                    uint32_t count, float *out0, float *out1)
{
    pattern_jitters(&light->plan->pattern, x, y, count,
                    pattern_light_dimension(light->index, light->strata), out0, out1);
    for (uint32_t i = 0; i < count; i++) {
        out0[i] = out0[i] < PATTERN_JITTER_MAX ? out0[i] : PATTERN_JITTER_MAX;
        out1[i] = out1[i] < PATTERN_JITTER_MAX ? out1[i] : PATTERN_JITTER_MAX;
    }
}

/* Transposes the bits of l rows, which follow each other, to columns. */
SIMD_INLINE void turn(uint32_t l, const uint8_t *bytes, uint32_t columns[SHADOW_STRATA_MAX])
{
    for (uint32_t a = 0; a < l; a++) {
        uint32_t column = 0;
        for (uint32_t b = 0, k = a; b < l; b++, k += l)
            column |= ((uint32_t)bytes[k >> 3] >> (k & 7u) & 1u) << b;
        columns[a] = column;
    }
}

void strata_columns(const struct receiver_light *light, const struct patch *patch, size_t i,
                    uint32_t columns[SHADOW_STRATA_MAX])
{
    const size_t area = (size_t)rect_area(patch->rect);
    const uint8_t *visibility = patch->lights[light->index].visibility + i;
    const uint32_t l = light->strata;
    uint8_t bytes[SHADOW_STRATA_MAX * SHADOW_STRATA_MAX / 8] = {0};
    for (uint32_t k = 0; k < (l * l + 7) / 8; k++) bytes[k] = visibility[k * area];
    if (l == 3)
        turn(3, bytes, columns); /* the loops in there come apart */
    else
        turn(l, bytes, columns);
}

void strata_bits(const struct receiver_light *light, const struct patch *patch, size_t first,
                 uint32_t count, uint32_t *bits, size_t stride)
{
    const size_t area = (size_t)rect_area(patch->rect);
    const uint8_t *bytes = patch->lights[light->index].visibility + first;
    const uint32_t strata = light->strata * light->strata;
    for (uint32_t k = 0; k < strata; k += 8, bytes += area) {
        const uint32_t left = strata - k, all = left < 8 ? (1u << left) - 1 : 0xffu;
        uint32_t *word = bits + k / 32 * stride;
        for (uint32_t i = 0; i < count; i++) {
            const uint32_t before = k % 32 == 0 ? 0u : word[i];
            word[i] = before | (bytes[i] & all) << k % 32;
        }
    }
}

/* Returns whether 1 to STRATA_RUN pixels of a row see all strata. */
static bool all_seen(const uint32_t *bits, size_t stride, uint32_t count, uint32_t strata)
{
    uint32_t missing = 0;
    for (uint32_t k = 0; k < strata; k += 32) {
        const uint32_t *word = bits + k / 32 * stride, left = strata - k;
        const uint32_t all = left < 32 ? (1u << left) - 1 : 0xffffffffu;
        for (uint32_t i = 0; i < count; i++) missing |= ~word[i] & all;
    }
    return missing == 0;
}

void strata_row_jitters(const struct receiver_light *light, int32_t x, int32_t y, uint32_t count,
                        float *out0, float *out1)
{
    int32_t at_x[STRATA_RUN], at_y[STRATA_RUN];
    for (int32_t i = 0; i < STRATA_RUN; i++) {
        at_x[i] = x + i;
        at_y[i] = y;
    }
    strata_jitters(light, at_x, at_y, count, out0, out1);
}

void strata_estimate(const struct receiver_light *light, const struct patch *patch,
                     const struct shadow_kernels *kernels, int32_t x, int32_t y, uint32_t count,
                     float *out)
{
    uint32_t bits[STRATA_WORDS * STRATA_RUN];
    float point[3][STRATA_RUN], normal[3][STRATA_RUN], jitter[2][STRATA_RUN];
    float *const points[3] = {point[0], point[1], point[2]};
    float *const normals[3] = {normal[0], normal[1], normal[2]};
    const float *const p[3] = {point[0], point[1], point[2]};
    const float *const n[3] = {normal[0], normal[1], normal[2]};
    const float *const j[2] = {jitter[0], jitter[1]};
    const size_t first = patch_pixel(patch, x, y);
    const uint32_t l = light->strata;
    strata_bits(light, patch, first, count, bits, STRATA_RUN);
    if (all_seen(bits, STRATA_RUN, count, l * l)) {
        for (uint32_t i = 0; i < count; i++) out[i] = 1.0f;
        return;
    }
    receiver_row(light, patch, x, y, count, points, normals);
    strata_row_jitters(light, x, y, count, jitter[0], jitter[1]);
    kernels->estimate(&light->rectangle, l, count, p, n, j, bits, STRATA_RUN, out);
}
