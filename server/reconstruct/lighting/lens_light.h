#pragma once
/* Light fields of pixel centres light lens samples (docs/reconstruction.md, Light through the
 * lens): the lighting of what the middle of the lens sees is filtered first, and each sample of the
 * lens then takes it from where the middle sees the same point. A sample of pixel position p at
 * lens position u with slope s shows what a pinhole shows at q = p + s u (lens_pattern.h); the
 * pixels around q that show its surface lend their lighting. Where none does, the point is hidden
 * from the middle, and the sample keeps what its own path has found.
 *
 * What is lent is linear between pixel centres, at any number of samples: a sharp shadow's edge
 * between two of them stays a ramp as wide as a pixel, however many samples look at it. */
#include "server/reconstruct/lighting/lighting.h"

struct lens_light_statistics {
    uint64_t samples_lit; /* of the block: by the field */
    uint64_t samples_own; /* by their own paths */
};

/* Pixels around a block whose lighting its lens samples, and those around that its lens filter
 * looks at, may take; 0 where light fields light none. */
int32_t lens_light_ring_px(const struct plan *plan);

/* Radiance of those lens samples of `seen`, which lies in the patch, that the filter of `block`
 * reads (lens_cull.h), lit by `lighting`, which is of `lit`: as patch->lens_radiance lies,
 * l_u^2 * 3 planes, and may be these; others are not set or not lit. Counts samples of `block`.
 * ERR_MEMORY; ERR_RANGE without the planes. */
int lens_light_take(const struct plan *plan, const struct patch *patch,
                    const struct lighting *lighting, struct rect lit, struct rect seen,
                    struct rect block, float *radiance, struct lens_light_statistics *statistics);
