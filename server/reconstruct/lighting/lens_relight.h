#pragma once
/* Relights lens samples from the light fields of pixel centres (docs/reconstruction.md, Light
 * through the lens). The lighting of what the centre of the lens sees is filtered first. Each lens
 * sample then looks it up at the pixel where the centre sees the same point. A sample of pixel
 * position p at lens position u with slope s shows what a pinhole shows at q = p + s u
 * (lens_pattern.h). The lighting of the pixels around q that show its surface is interpolated. If
 * there are none, the point is disoccluded, and the sample keeps its own path's light.
 *
 * Looked-up light is linear between pixel centres, at any number of samples: the edge of a sharp
 * shadow between two of them stays a ramp of one pixel's width. */
#include "server/reconstruct/lighting/lighting.h"

struct lens_relight_statistics {
    uint64_t samples_lit; /* of the block, lit by look-up */
    uint64_t samples_own; /* lit by their own paths */
};

/* Returns how many pixels around a block need lighting, for its lens samples and for those around
 * that its lens filter reads; 0 without look-up. */
int32_t lens_relight_ring_px(const struct plan *plan);

/* Writes the radiance of the lens samples of `seen`, which lies in the patch, that the filter of
 * `block` reads (lens_cull.h). They are lit by `lighting`, which covers `lit`. The result has the
 * layout of patch->lens_radiance, l_u^2 * 3 planes, and may be that array; other samples are not
 * set or not lit. Counts samples of `block`. ERR_MEMORY; ERR_RANGE without the planes. */
int lens_relight_take(const struct plan *plan, const struct patch *patch,
                      const struct lighting *lighting, struct rect lit, struct rect seen,
                      struct rect block, float *radiance,
                      struct lens_relight_statistics *statistics);
