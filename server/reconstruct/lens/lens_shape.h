#pragma once
/* The aperture as a measure of length: the size of the copy around the origin on whose edge a point
 * lies. */
#include "proto/lens_pattern.h"
#include "server/reconstruct/lens/lens_kernels.h"

struct lens_shape {
    uint32_t edges; /* 0: round */
    float normal[2 * LIMIT_LENS_BLADES][2];
    float inradius;           /* distance of the edges from the centre; 1 when round */
    float share[LENS_GROUPS]; /* of the area, by quarters; added in turn they are 1 */
};

void lens_shape_init(struct lens_shape *out, const struct lens_aperture *aperture);

/* Returns, for the point (x, y), right and down, the inradius times the scale of the copy on whose
 * edge it lies. */
float lens_shape_distance(const struct lens_shape *shape, float x, float y);

/* Returns the quarter that a point is in. */
static inline uint32_t lens_shape_group(float x, float y)
{
    return (x >= 0.0f ? 1u : 0u) + (y >= 0.0f ? 2u : 0u);
}
