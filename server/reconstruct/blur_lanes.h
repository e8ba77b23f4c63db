#pragma once
/* shadow_kernels' blur. */
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compatible_lanes.h"
#include "server/reconstruct/gaussian.h"

/* SHADOW_LANES pixels side by side from `at` on, `most` taps to both sides. */
static inline void blur_group(const struct shadow_blur *f, int32_t step, size_t at, int32_t most,
                              float out[SHADOW_LANES])
{
    const struct shadow_pixels *pixels = f->pixels;
    const float *px = pixels->point[0], *py = pixels->point[1], *pz = pixels->point[2];
    const float *nx = pixels->normal[0], *ny = pixels->normal[1], *nz = pixels->normal[2];
    const float *plane_least = pixels->plane_least, *distance_most2 = pixels->distance_most2;
    const float *falloff = f->falloff, *refusal = f->refusal, *seen = f->seen;
    const int32_t *reach = f->reach;
    _Alignas(64) float sum[SHADOW_LANES] = {0}, weights[SHADOW_LANES] = {0};
    for (int32_t k = -most; k <= most; k++) {
        const size_t to = (size_t)((ptrdiff_t)at + (ptrdiff_t)k * step);
        const int32_t away = k < 0 ? -k : k;
        const float own = k == 0 ? INFINITY : 0.0f; /* nothing refuses itself */
        for (size_t lane = 0; lane < SHADOW_LANES; lane++) {
            const size_t p = at + lane, q = to + lane;
            const struct asker asker = {
                {px[p], py[p], pz[p]}, {nx[p], ny[p], nz[p]}, plane_least[p], distance_most2[p]};
            float squared;
            const int32_t same =
                compatible_point(&asker, px[q], py[q], pz[q], nx[q], ny[q], nz[q], &squared);
            const float exponent = squared * falloff[p], value = seen[q];
            const float near = refusal[q] > own ? refusal[q] : own;
            const int32_t kept =
                same & (away <= reach[p]) & (exponent <= SHADOW_AXIS_CUT) & (squared <= near);
            const float all = gaussian_exp_minus(exponent), w = kept ? all : 0.0f;
            sum[lane] = fused(w, value, sum[lane]);
            weights[lane] += w;
        }
    }
    for (size_t lane = 0; lane < SHADOW_LANES; lane++) {
        const float value = seen[at + lane], all = weights[lane];
        const float mean = sum[lane] / (all > 0.0f ? all : 1.0f);
        out[lane] = all > 0.0f ? mean : value;
    }
}

static void kernel_blur(const struct shadow_blur *f, int32_t step, size_t first, uint32_t count,
                        float *out)
{
    for (uint32_t i = 0; i < count; i += SHADOW_LANES) {
        const uint32_t left = count - i, n = left < SHADOW_LANES ? left : SHADOW_LANES;
        int32_t most = 0;
        _Alignas(64) float group[SHADOW_LANES];
        for (uint32_t k = 0; k < n; k++)
            most = most > f->reach[first + i + k] ? most : f->reach[first + i + k];
        if (most > 0)
            blur_group(f, step, first + i, most, group);
        else
            memcpy(group, f->seen + first + i, n * sizeof *group);
        memcpy(out + i, group, n * sizeof *group);
    }
}
