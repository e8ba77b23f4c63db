#pragma once
/* Views of float planes: what the film hands to reconstruction and reconstruction to the encoders.
 */
#include <stddef.h>
#include <stdint.h>

/* width x height floats, rows `stride` floats apart. Borrowed. */
struct plane {
    float *data;
    int32_t width_px, height_px;
    ptrdiff_t stride;
};

static inline float *plane_row(const struct plane *p, int32_t y)
{
    return p->data + (ptrdiff_t)y * p->stride;
}

static inline float *plane_at(const struct plane *p, int32_t x, int32_t y)
{
    return plane_row(p, y) + x;
}
