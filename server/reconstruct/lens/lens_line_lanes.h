#pragma once
/* The lines that lens points of pixels lie on, for many pixels at a time. The bits are those of
 * lens_aperture_lines. The loops have independent iterations, which the compiler vectorises. */
#include <math.h>

#include "proto/lens_pattern.h"

/* Returns the band that a share of the area lies in. */
static inline uint32_t lens_line_band(const struct lens_aperture *a, float share)
{
    uint32_t band = 0;
    while (band + 1 < a->bands && a->below[band + 1] < share) band++;
    return band;
}

/* Computes where lines lie in band b, for pixels whose share of the area is above `from`. */
static inline void lens_line_fill(const struct lens_aperture *a, uint32_t b, float from, uint32_t l,
                                  uint32_t i, uint32_t count, const float *restrict across,
                                  float *restrict height, float *restrict left,
                                  float *restrict length)
{
    const float low = a->height[b], below = a->below[b], all = a->area;
    const float left_low = a->left[b], left_more = a->left[b + 1] - left_low;
    const float right_low = a->right[b], right_more = a->right[b + 1] - right_low;
    const float h = a->height[b + 1] - low, w0 = right_low - left_low;
    const float growth = 2.0f * (a->right[b + 1] - a->left[b + 1] - w0) / h;
    for (uint32_t k = 0; k < count; k++) {
        const float share = pattern_axis(across[k], l, i), more = share - below;
        const float area = (more > 0.0f ? more : 0.0f) * all, square = w0 * w0 + growth * area;
        const float under = w0 + sqrtf(square > 0.0f ? square : 0.0f);
        const float y = 2.0f * area / (under > 1e-9f ? under : 1.0f);
        const float rise = under > 1e-9f ? (y < h ? y : h) : 0.0f, at = low + rise;
        const float t = (at - low) / h;
        const float begin = left_low + t * left_more, end = right_low + t * right_more;
        const float middle = 0.5f * (begin + end);
        const int has_length = (t >= 0.0f) & (t <= 1.0f) & (begin <= end), taken = share > from;
        const float first = has_length ? begin : middle, last = has_length ? end : middle;
        height[k] = taken ? at : height[k];
        left[k] = taken ? first : left[k];
        length[k] = taken ? last - first : length[k];
    }
}

/* Fills band by band. Each overwrites the pixels of the one below that lie above that. */
static inline void lens_band_lines(const struct lens_aperture *a, uint32_t l, uint32_t i,
                                   uint32_t count, const float *across, float *height, float *left,
                                   float *length)
{
    const uint32_t first = lens_line_band(a, pattern_axis(0.0f, l, i)),
                   last = lens_line_band(a, pattern_axis(1.0f, l, i));
    for (uint32_t b = first; b <= last; b++)
        lens_line_fill(a, b, b == first ? -1.0f : a->below[b], l, i, count, across, height, left,
                       length);
}
