#pragma once
/* Depth of field from few lens samples.
 *
 * LENS_FILTER_SHEARED projects samples along their slopes onto layers, images of what lies between
 * two slopes, because the light field of one layer is constant along x + s u
 * (docs/reconstruction.md, Lens layers). Each pixel then looks at the layers through its own
 * aperture, nearest first, as in Vaidyanathan et al. 2015, "Layered light field reconstruction for
 * defocus blur". The smoothed difference to the plain average is added where it is more than noise,
 * so that errors fall with every sample.
 *
 * LENS_FILTER_AXIS_ALIGNED weights by Gaussians of the pixels' least slopes
 * (docs/reconstruction.md, Lens samples).
 *
 * The filter is a pure function of its arguments; any thread may call it. Arrays are those of a
 * patch: width * height of its rect, row by row. It reads within lens_halo_px of a pixel. */
#include "server/reconstruct/patch/patch.h"

struct lens_statistics {
    uint64_t pixels_filtered;
    uint64_t pixels_skipped; /* in focus: the plain average */
    uint64_t blocks_skipped; /* calls that met only such pixels */
};

/* Returns how many pixels around a block the plan's filter reads; 0 for LENS_FILTER_NONE. It
 * depends on the plan alone. */
int32_t lens_halo_px(const struct plan *plan);

/* Writes the picture of `inner`, which lies in patch->rect, into out[3], and the filter's
 * standard deviation in pixels (0: not filtered; may be NULL) into width_px. Adds to *statistics.
 * LENS_FILTER_NONE gives the plain average. Results are finite for finite samples. Where all
 * samples are 1, or any power of two, so is the picture, to the last bit. ERR_MEMORY; ERR_RANGE for
 * an unknown filter, a missing plane or an `inner` outside. */
int lens_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                float *const out[3], float *width_px, struct lens_statistics *statistics);
