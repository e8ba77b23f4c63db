#pragma once
/* The surfaces that pixels and sub-samples of a patch show, as proto/surface_match.h compares them.
 */
#include "proto/surface_match.h"
#include "server/reconstruct/patch/patch.h"

/* Points at `depth` along the rays through the centres of `count` pixels from image pixel (x, y)
 * on, relative to the eye, along the world's axes; depth 0 gives 0 of a perspective camera. */
void surface_points(const struct surface_view *view, int32_t x, int32_t y, uint32_t count,
                    const float *restrict depth, float *restrict px, float *restrict py,
                    float *restrict pz);

/* Pixel i of the patch (the ray through its centre) and sub-sample k of it, which lies at `offset`
 * within the pixel. False when there is no surface. */
bool surface_of_pixel(const struct surface_view *view, const struct patch *patch, size_t i,
                      struct shown_surface *out);
bool surface_of_sub(const struct surface_view *view, const struct patch *patch, size_t i,
                    uint32_t k, const float offset[2], struct shown_surface *out);

/* True only when surface_match of pixel i and its own sub-sample k is 1, whatever the sub-sample's
 * place in the pixel: most of a picture is decided by it. False says nothing. *facing belongs to
 * pixel i and starts as zeros. */
bool surface_surely_same(const struct surface_view *view, const struct patch *patch, size_t i,
                         uint32_t k, struct surface_facing *facing);
