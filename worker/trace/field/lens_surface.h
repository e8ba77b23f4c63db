#pragma once
/* What lens samples tell of the surfaces they meet, for light fields of pixel centres to light
 * them; and what is left of the samples without that light. */
#include <float.h>

#include "proto/samples.h"
#include "worker/trace/path/path.h"

/* Slopes A f_px (1/z - 1/F) of a plan's points: A f_px and 1/F. */
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

/* PLANE_LENS_SLOPE's of a point z > 0 ahead of the lens. */
static inline float lens_slope(struct lens_sloper s, float z)
{
    return s.scale * (1.0f / z - s.inverse_focus);
}

/* Takes the light that fields bring out of what the harvest's slot holds. */
void lens_surface_take_out(const struct path_context *c, size_t slot, struct path_harvest *h);

/* Stores depth, normal, albedo and own light of lens sample `sample`, which lies in the harvest
 * from slot `first` on, and takes that light out of what the harvest holds. Nothing happens under a
 * plan whose light fields light no lens samples. */
void lens_surface_store(const struct path_context *c, const struct block *b, size_t first,
                        uint32_t sample, struct path_harvest *h, struct samples *samples);
