#pragma once
/* shadow_kernels' blur and sum_slopes. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/gaussian.h"

/* Sums are kept in as many parts as there are lanes, added up in pairs at the end. */
static inline float blur_total(float parts[SHADOW_LANES])
{
    for (uint32_t half = SHADOW_LANES / 2; half > 0; half /= 2) {
        for (uint32_t i = 0; i < half; i++) parts[i] += parts[i + half];
    }
    return parts[0];
}

static inline float blur_one(const struct shadow_source *p, const struct shadow_target *t,
                             int32_t reach, int32_t step, struct shadow_lanes *q)
{
    const struct asker asker = asker_of(p, t);
    const float width = t->width;
    const int32_t count = 2 * reach + 1;
    const int32_t padded = (count + SHADOW_LANES - 1) / SHADOW_LANES * SHADOW_LANES;
    float sum[SHADOW_LANES] = {0}, weights[SHADOW_LANES] = {0};
    for (int32_t i = 0; i < padded; i++) q->to[i] = i < count ? (i - reach) * step : 0;
    lanes_fetch(p, (size_t)padded, SHADOW_SEEN + 4, q);
    for (int32_t first = 0; first < padded; first += SHADOW_LANES) {
        for (int32_t lane = 0; lane < SHADOW_LANES; lane++) {
            const int32_t i = first + lane;
            float squared;
            const int32_t same = compatible(&asker, q, (size_t)i, &squared);
            const float exponent = squared * width;
            const int32_t kept = same & (i < count) & (exponent <= SHADOW_AXIS_CUT) &
                                 ((i == reach) | (squared <= q->number[SHADOW_REFUSAL][i]));
            const float all = gaussian_exp_minus(exponent), w = kept ? all : 0.0f;
            sum[lane] += w * q->number[SHADOW_SEEN][i];
            weights[lane] += w;
        }
    }
    const float total = blur_total(weights);
    return total > 0.0f ? blur_total(sum) / total : p->seen;
}

static void kernel_blur(const struct shadow_field *f, uint32_t axis, const uint32_t *pixels,
                        uint32_t count, float *out)
{
    struct shadow_lanes lanes;
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_target *t = &f->targets[pixels[k]];
        out[k] = blur_one(&f->sources[pixels[k]], t, t->walk[axis].reach, axis == 0 ? 1 : f->width,
                          &lanes);
    }
}

#define SLOPES_SIDE  5
#define SLOPES_LANES 32 /* SLOPES_SIDE squared, filled up to whole lanes */

/* Those of the pixels around that have values (not below 0), from the top left: their offsets into
 * q->to, filled up to whole lanes. Returns how many. */
static inline size_t slopes_take(const int32_t around[SLOPES_LANES], const float *a,
                                 struct shadow_lanes *q)
{
    _Alignas(64) int32_t full[SLOPES_LANES] = {0};
    int32_t kept[SLOPES_LANES];
    for (int32_t i = 0; i < SLOPES_SIDE * SLOPES_SIDE; i++) full[i] = !(a[around[i]] < 0.0f);
    const size_t count = lanes_kept(full, SLOPES_LANES, kept);
    for (size_t i = 0; i < count; i++) q->to[i] = around[kept[i]];
    for (size_t i = count; i % SHADOW_LANES != 0; i++) q->to[i] = 0;
    return count;
}

static void kernel_sum_slopes(const struct shadow_field *f, const uint32_t *pixels, uint32_t count,
                              const float *a, const float *b, float *out)
{
    struct shadow_lanes q;
    int32_t around[SLOPES_LANES] = {0};
    for (int32_t i = 0; i < SLOPES_SIDE * SLOPES_SIDE; i++)
        around[i] = (i / SLOPES_SIDE - 2) * f->width + i % SLOPES_SIDE - 2;
    for (uint32_t k = 0; k < count; k++) {
        const struct shadow_source *p = &f->sources[pixels[k]];
        const struct asker asker = asker_of(p, &f->targets[pixels[k]]);
        const float *here_a = a + pixels[k], *here_b = b + pixels[k];
        int32_t same[SLOPES_LANES];
        float sums[3] = {0};
        const size_t n = slopes_take(around, here_a, &q);
        const size_t padded = (n + SHADOW_LANES - 1) / SHADOW_LANES * SHADOW_LANES;
        lanes_fetch(p, padded, SHADOW_ETA, &q);
        for (size_t i = 0; i < padded; i++) {
            float squared;
            same[i] = compatible(&asker, &q, i, &squared);
        }
        for (size_t i = 0; i < n; i++) {
            if (!same[i]) continue;
            sums[0] += 1.0f;
            sums[1] += here_a[q.to[i]];
            sums[2] += here_b[q.to[i]];
        }
        memcpy(out + (size_t)k * 3, sums, sizeof sums);
    }
}
