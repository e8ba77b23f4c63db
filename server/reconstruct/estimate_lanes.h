#pragma once
/* shadow_kernels' estimate: sum of I G V over sum of I G at a pixel's strata. */
#include "proto/pattern.h"
#include "proto/plan.h"
#include "server/reconstruct/gaussian.h"
#include "server/reconstruct/shadow_lanes.h"

#define ESTIMATE_NEAR_MOST 1e9f /* (size / distance)^2 */

/* Receivers side by side; those past the end have no normal. */
struct estimate_chunk {
    float to[3][SHADOW_LANES], normal[3][SHADOW_LANES];
    float u[SHADOW_STRATA_MAX][SHADOW_LANES], v[SHADOW_LANES], jitter[2][SHADOW_LANES];
    float seen[SHADOW_LANES], all[SHADOW_LANES], count[SHADOW_LANES];
    int32_t bit[SHADOW_LANES];
};

static inline void estimate_load(const struct shadow_rectangle *light, size_t first, size_t count,
                                 const float *const point[3], const float *const normal[3],
                                 const float *const jitter[2], struct estimate_chunk *c)
{
    for (int k = 0; k < 3; k++) {
        for (size_t i = count; i < SHADOW_LANES; i++) c->to[k][i] = c->normal[k][i] = 0.0f;
        for (size_t i = 0; i < count; i++) {
            c->to[k][i] = light->centre[k] - point[k][first + i];
            c->normal[k][i] = normal[k][first + i];
        }
    }
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < SHADOW_LANES; i++)
            c->jitter[k][i] = i < count ? jitter[k][first + i] : 0.0f;
    }
}

/* Stratum k of the receivers into c->bit. */
static inline void estimate_bits(const uint32_t *bits, size_t stride, size_t first, size_t count,
                                 uint32_t k, struct estimate_chunk *c)
{
    const uint32_t *word = bits + k / 32 * stride + first;
    for (size_t i = 0; i < count; i++) c->bit[i] = (int32_t)(word[i] >> (k & 31u) & 1u);
}

/* Is each receiver's light all seen or not seen at all? Then c->bit says which. */
static inline bool estimate_is_plain(const uint32_t *bits, size_t stride, size_t first,
                                     size_t count, uint32_t strata, struct estimate_chunk *c)
{
    uint32_t some[SHADOW_LANES] = {0}, missing[SHADOW_LANES] = {0};
    int32_t mixed = 0;
    for (uint32_t k = 0; k < strata; k += 32) {
        const uint32_t *word = bits + k / 32 * stride + first;
        const uint32_t left = strata - k, all = left < 32 ? (1u << left) - 1 : 0xffffffffu;
        for (size_t i = 0; i < count; i++) {
            some[i] |= word[i] & all;
            missing[i] |= ~word[i] & all;
        }
    }
    for (size_t i = 0; i < count; i++) {
        mixed |= (some[i] != 0) & (missing[i] != 0);
        c->bit[i] = some[i] != 0;
    }
    return !mixed;
}

/* One stratum, (u, v) in [-1, 1]^2 of the light. I G but for factors that all strata share; in
 * units of the light's size and bounded, so that squares of squares stay finite. */
static inline void estimate_add(const struct shadow_rectangle *r, const float u[SHADOW_LANES],
                                struct estimate_chunk *c)
{
    const float hu = r->half[0], hv = r->half[1], size2 = hu * hu + hv * hv;
    const float *a = r->axis[0], *b = r->axis[1];
    const float spread = r->profile == PROFILE_GAUSSIAN ? 2.0f : 0.0f; /* exp(0) is 1 */
    for (size_t i = 0; i < SHADOW_LANES; i++) {
        const float along = u[i] * hu, aside = c->v[i] * hv;
        const float x = c->to[0][i] + along * a[0] + aside * b[0];
        const float y = c->to[1][i] + along * a[1] + aside * b[1];
        const float z = c->to[2][i] + along * a[2] + aside * b[2];
        const float up = x * c->normal[0][i] + y * c->normal[1][i] + z * c->normal[2][i];
        const float squared = x * x + y * y + z * z;
        const float profile = gaussian_exp_minus(spread * (u[i] * u[i] + c->v[i] * c->v[i]));
        const float near = size2 / (squared > 0.0f ? squared : 1.0f);
        const float bounded = near < ESTIMATE_NEAR_MOST ? near : ESTIMATE_NEAR_MOST;
        const float g = profile * up * (bounded * bounded);
        const float weight = ((up > 0.0f) & (squared > 0.0f)) ? g : 0.0f;
        c->all[i] += weight;
        c->seen[i] += c->bit[i] ? weight : 0.0f;
        c->count[i] += (float)c->bit[i];
    }
}

static void kernel_estimate(const struct shadow_rectangle *light, uint32_t l, uint32_t count,
                            const float *const point[3], const float *const normal[3],
                            const float *const jitter[2], const uint32_t *bits, size_t stride,
                            float *out)
{
    struct estimate_chunk c = {0};
    const float strata = (float)(l * l);
    for (size_t first = 0; first < count; first += SHADOW_LANES) {
        const size_t left = count - first, n = left < SHADOW_LANES ? left : SHADOW_LANES;
        const bool plain = estimate_is_plain(bits, stride, first, n, l * l, &c);
        for (size_t i = 0; plain && i < n; i++) out[first + i] = (float)c.bit[i];
        if (plain) continue;
        estimate_load(light, first, n, point, normal, jitter, &c);
        for (uint32_t a = 0; a < l; a++) {
            for (size_t i = 0; i < SHADOW_LANES; i++)
                c.u[a][i] = 2.0f * pattern_axis(c.jitter[0][i], l, a) - 1.0f;
        }
        for (size_t i = 0; i < SHADOW_LANES; i++) c.seen[i] = c.all[i] = c.count[i] = 0.0f;
        for (uint32_t k = 0; k < l * l; k++) {
            for (size_t i = 0; k % l == 0 && i < SHADOW_LANES; i++)
                c.v[i] = 2.0f * pattern_axis(c.jitter[1][i], l, k / l) - 1.0f;
            estimate_bits(bits, stride, first, n, k, &c);
            estimate_add(light, c.u[k % l], &c);
        }
        for (size_t i = 0; i < n; i++)
            out[first + i] = c.all[i] > 0.0f ? c.seen[i] / c.all[i] : c.count[i] / strata;
    }
}
