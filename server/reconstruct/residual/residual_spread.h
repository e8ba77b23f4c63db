#pragma once
/* Spreads what spikes had beyond their limits over pixels with like features: as far as it takes to
 * know how much light they stand for, and no farther (docs/reconstruction.md, Residual spikes). */
#include "server/reconstruct/patch/spike_limits.h"
#include "server/reconstruct/residual/residual_field.h"
#include "server/reconstruct/residual/residual_spread_kernels.h"

/* How far from a pixel spikes are taken from. */
#define RESIDUAL_SPREAD_PX 51

/* Planes of scratch that it needs. */
#define RESIDUAL_SPREAD_PLANES 17

/* Returns how much features of pixels i and j have in common, 0 .. 1, for `way` pixels along a
 * slope. */
static inline float residual_alike(const struct residual_features *f, const float *slope, size_t i,
                                   size_t j, float way)
{
    const size_t n = f->shape.plane;
    const float *x = f->normal, *y = x + n, *z = y + n, *d = f->nearness;
    const float a = x[i] - x[j], b = y[i] - y[j], c = z[i] - z[j];
    const float turn = a * a + b * b + c * c, along = slope[i] * way;
    const float off =
        (d[j] - d[i] - along) / (RESIDUAL_NEARNESS_PART * d[i] + fabsf(along) + 1e-30f);
    const float left = 1.0f - turn / RESIDUAL_TURN_MAX - off * off - f->barred[i] - f->barred[j];
    return left > 0.0f ? left : 0.0f;
}

/* Replaces `excess`, 3 planes of what spikes of a component had beyond their limits, by what it
 * stands for in each pixel of `area`. Links of `limits` are set; its other arrays but `limit` are
 * overwritten. */
void residual_spread(const struct residual_features *f, enum residual_component component,
                     const struct spike_limits *limits, struct rect area,
                     float *const scratch[RESIDUAL_SPREAD_PLANES], float *const excess[3]);
