#pragma once
/* shadow_kernels' blur and sum_slopes. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/gaussian.h"

/* SHADOW_LANES pixels side by side from `at` on, `most` taps to both sides. */
static inline void blur_group(const struct shadow_blur *f, int32_t step, size_t at, int32_t most,
                              float out[SHADOW_LANES])
{
    const float *px = f->point[0], *py = f->point[1], *pz = f->point[2];
    const float *nx = f->normal[0], *ny = f->normal[1], *nz = f->normal[2];
    const float *plane_least = f->plane_least, *distance_most2 = f->distance_most2;
    const float *falloff = f->falloff, *refusal = f->refusal, *seen = f->seen;
    const int32_t *reach = f->reach;
    float sum[SHADOW_LANES] = {0}, weights[SHADOW_LANES] = {0};
    for (int32_t k = -most; k <= most; k++) {
        const size_t to = (size_t)((ptrdiff_t)at + (ptrdiff_t)k * step);
        const int32_t away = k < 0 ? -k : k;
        for (size_t lane = 0; lane < SHADOW_LANES; lane++) {
            const size_t p = at + lane, q = to + lane;
            const struct asker asker = {
                {px[p], py[p], pz[p]}, {nx[p], ny[p], nz[p]}, plane_least[p], distance_most2[p]};
            float squared;
            const int32_t same =
                compatible_point(&asker, px[q], py[q], pz[q], nx[q], ny[q], nz[q], &squared);
            const float exponent = squared * falloff[p], value = seen[q];
            const int32_t kept = same & (away <= reach[p]) & (exponent <= SHADOW_AXIS_CUT) &
                                 ((away == 0) | (squared <= refusal[q]));
            const float all = gaussian_exp_minus(exponent), w = kept ? all : 0.0f;
            sum[lane] += w * value;
            weights[lane] += w;
        }
    }
    for (size_t lane = 0; lane < SHADOW_LANES; lane++)
        out[lane] = weights[lane] > 0.0f ? sum[lane] / weights[lane] : seen[at + lane];
}

static void kernel_blur(const struct shadow_blur *f, int32_t step, size_t first, uint32_t count,
                        float *out)
{
    for (uint32_t i = 0; i < count; i += SHADOW_LANES) {
        const uint32_t left = count - i, n = left < SHADOW_LANES ? left : SHADOW_LANES;
        int32_t most = 0;
        float group[SHADOW_LANES];
        for (uint32_t k = 0; k < n; k++)
            most = most > f->reach[first + i + k] ? most : f->reach[first + i + k];
        if (most > 0)
            blur_group(f, step, first + i, most, group);
        else
            memcpy(group, f->seen + first + i, n * sizeof *group);
        memcpy(out + i, group, n * sizeof *group);
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
        int32_t same[SLOPES_LANES] = {0};
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
