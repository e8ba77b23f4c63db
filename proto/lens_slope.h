#pragma once
/* The slope of a point is the number of pixels that it moves across the image from the centre to
 * the rim of the lens: A f_px (1/z - 1/F). */
#include <float.h>

#include "proto/half.h"
#include "proto/plan.h"

/* A plan's A f_px and 1/F. */
struct lens_sloper {
    float scale, inverse_focus;
};

static inline struct lens_sloper lens_sloper_of(const struct plan *plan)
{
    const struct plan_camera *camera = &plan->camera;
    const float focus = camera->focus_distance;
    return (struct lens_sloper){camera->aperture_radius * (float)plan->width_px /
                                    (2.0f * camera->half_width), /* plan_decode: > 0 */
                                1.0f / (focus > FLT_MIN ? focus : FLT_MIN)};
}

/* Returns the slope (PLANE_LENS_SLOPE) of a point z > 0 ahead of the lens. */
static inline float lens_slope(struct lens_sloper s, float z)
{
    return s.scale * (1.0f / z - s.inverse_focus);
}

/* Returns the slope, a half float, of what meets nothing. */
static inline float lens_slope_sky(struct lens_sloper s)
{
    const float own = -s.scale * s.inverse_focus;
    return half_to_float(half_from_float(own > -65504.0f ? own : -65504.0f));
}
