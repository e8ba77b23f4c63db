#pragma once
/* hit_kernels' place_texels: where texture_sample (worker/scene/material/texture.c) reads, in
 * sixteen lanes. */
#include <math.h>

#include "worker/trace/hit/texels.h"

/* The two texels of an axis, of 0 .. size - 1, and the weight of the second. */
struct axis_lanes {
    _Alignas(LANES_ALIGN) int32_t first[LANES];
    _Alignas(LANES_ALIGN) int32_t second[LANES];
};

LANE_INLINE float wrapped(float c, uint32_t mode)
{
    float folded = c - floorf(c);
    if (mode == WRAP_CLAMP) {
        folded = c > 1.0f ? 1.0f : c;
        folded = c < 0.0f ? 0.0f : folded;
    } else if (mode == WRAP_MIRROR) {
        float half = c * 0.5f, phase = 2.0f * (half - floorf(half));
        folded = phase > 1.0f ? 2.0f - phase : phase;
    }
    return fabsf(c) < TEXTURE_COORDINATE_MAX ? folded : 0.0f; /* NaN, too */
}

LANE_INLINE int32_t wrapped_texel(int32_t i, int32_t size, bool repeats)
{
    const int32_t below = repeats ? size - 1 : 0, above = repeats ? 0 : size - 1;
    const int32_t inside = i >= size ? above : i;
    return i < 0 ? below : inside;
}

LANE_INLINE void place_axis(const float *restrict m, const float *restrict u,
                            const float *restrict v, int32_t size, uint32_t mode, bool nearest,
                            struct axis_lanes *restrict out, float *restrict part)
{
    const float texels = (float)size;
    const bool repeats = mode == WRAP_REPEAT;
    for (int i = 0; i < LANES; i++) {
        float at = wrapped(m[0] * u[i] + m[1] * v[i] + m[2], mode) * texels;
        float x = at - 0.5f;
        int32_t left = (int32_t)(x + 1.0f) - 1; /* x > -1: floor */
        part[i] = nearest ? 0.0f : x - (float)left;
        left = nearest ? (int32_t)at : left;
        out->first[i] = wrapped_texel(left, size, repeats);
        out->second[i] = nearest ? out->first[i] : wrapped_texel(left + 1, size, repeats);
    }
}

static void place_axis_by_mode(const float *m, const float *u, const float *v, int32_t size,
                               uint32_t mode, bool nearest, struct axis_lanes *out, float *part)
{
    if (mode == WRAP_CLAMP)
        place_axis(m, u, v, size, WRAP_CLAMP, nearest, out, part);
    else if (mode == WRAP_MIRROR)
        place_axis(m, u, v, size, WRAP_MIRROR, nearest, out, part);
    else
        place_axis(m, u, v, size, WRAP_REPEAT, nearest, out, part);
}

static void kernel_place_texels(const struct texture *t, const float *u, const float *v,
                                struct texel_lanes *restrict out)
{
    struct axis_lanes x, y;
    place_axis_by_mode(t->transform, u, v, t->width_px, t->wrap_u, t->nearest, &x, out->across);
    place_axis_by_mode(t->transform + 3, u, v, t->height_px, t->wrap_v, t->nearest, &y, out->down);
    for (int i = 0; i < LANES; i++) {
        const int32_t upper = y.first[i] * t->width_px, lower = y.second[i] * t->width_px;
        out->at[0][i] = upper + x.first[i];
        out->at[1][i] = upper + x.second[i];
        out->at[2][i] = lower + x.first[i];
        out->at[3][i] = lower + x.second[i];
    }
}
