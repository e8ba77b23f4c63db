#pragma once
/* The surfaces of a patch's pixels and sub-samples, as proto/surface_match.h compares them. */
#include "proto/surface_match.h"
#include "server/reconstruct/patch/patch.h"

/* Computes points at `depth` along the rays through the centres of `count` pixels from image pixel
 * (x, y) on, relative to the eye, along the world's axes. Under a perspective camera depth 0 gives
 * 0. */
void surface_points(const struct surface_view *view, int32_t x, int32_t y, uint32_t count,
                    const float *restrict depth, float *restrict px, float *restrict py,
                    float *restrict pz);

/* Return the surface of pixel i of the patch (along the ray through its centre), and of its
 * sub-sample k at `offset` within the pixel. False without a surface. */
bool surface_of_pixel(const struct surface_view *view, const struct patch *patch, size_t i,
                      struct shown_surface *out);
bool surface_of_sub(const struct surface_view *view, const struct patch *patch, size_t i,
                    uint32_t k, const float offset[2], struct shown_surface *out);

/* Returns true only if surface_match of pixel i and its own sub-sample k is 1, wherever the
 * sub-sample lies in the pixel, which decides most of a picture. False leaves it open. *facing
 * belongs to pixel i and starts as zeros. */
bool surface_surely_same(const struct surface_view *view, const struct patch *patch, size_t i,
                         uint32_t k, struct surface_facing *facing);
