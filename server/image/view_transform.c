#include "server/image/view_transform.h"

#include <math.h>

#include "server/image/view_kernels.h"

/* The exposure beyond which a float's range ends. */
#define EXPOSURE_MAX 126.0

struct view_transform view_transform_of(enum view_curve curve, double exposure_ev)
{
    const double stops = isnan(exposure_ev) ? 0 : exposure_ev;
    return (struct view_transform){.curve = curve,
                                   .scale = exp2(fmin(fmax(stops, -EXPOSURE_MAX), EXPOSURE_MAX)),
                                   .kernels = KERNELS_BEST(view_kernels)};
}

void view_transform_apply(const struct view_transform *view, struct view_pixels *pixels)
{
    view->kernels->show(view->curve, view->scale, pixels);
}
