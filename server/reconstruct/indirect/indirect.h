#pragma once
/* Diffuse indirect light and ambient occlusion from few samples, by axis-aligned filtering. Widths
 * follow from the distance of what lights a pixel (Mehta et al. 2013, "Axis-aligned filtering for
 * interactive physically-based diffuse indirect lighting"; the rules A and B and the blend of
 * docs/reconstruction.md, Indirect light).
 *
 *   reflector distances -> widths (harmonic means over the object, bandlimit, cap)
 *     -> pass along x, pass along y: weights of one surface, the same for all channels
 *
 * Under the sheared filter v_plane_filter makes the light, and rule A filters what else the rays
 * measured.
 *
 * A channel is anything that the same bounce rays measured per pixel: radiance, ambient visibility,
 * means over half of the samples. The filter is a pure function of its arguments; any thread may
 * call it. All arrays are those of a patch: width * height of its rect, row by row. What it reads
 * around a pixel lies within indirect_halo_px. */
#include "server/reconstruct/patch/patch.h"

#define INDIRECT_CHANNELS_MAX 8

struct indirect_statistics {
    uint64_t pixels_filtered;
    uint64_t pixels_isolated; /* of these (indirect_isolated.h) */
    uint64_t pixels_skipped;  /* no surface, or a black one: nothing was measured */
    uint64_t blocks_skipped;  /* blocks of only such pixels, for which no pass ran */
};

/* Returns how many pixels around a block the plan's filter reads; 0 for INDIRECT_FILTER_NONE. It
 * depends on the plan alone (samples, height, mu) and is at most INDIRECT_HALO_MAX_PX: the filter
 * itself reads INDIRECT_REACH_MAX_PX, what spreads spikes the rest. */
#define INDIRECT_REACH_MAX_PX 64
#define INDIRECT_HALO_MAX_PX  136
int32_t indirect_halo_px(const struct plan *plan);

/* Variances of the first three channels (indirect_variance.h). */
struct indirect_error {
    const float *
        half[3]; /* in: means over half of the samples; which half may change from pixel to pixel */
    float *variance[3]; /* out */
};

/* Filters `count` channels over `inner`, which lies in patch->rect. The patch needs depth, normal,
 * id and bounce_distance_min. Writes out[c] for the pixels of `inner` (0 where nothing was
 * measured) and the filter's standard deviation in pixels into width_px (0: not filtered; may be
 * NULL), and adds to *statistics. Constant channels stay constant; results are finite for finite
 * input. ERR_MEMORY; ERR_RANGE for another filter, a missing plane, too many channels or an `inner`
 * outside. */
int indirect_filter(const struct plan *plan, const struct patch *patch, struct rect inner,
                    uint32_t count, const float *const *in, float *const *out, float *width_px,
                    struct indirect_statistics *statistics);

/* Does the same and fills *error, for a plan with halves. count <= INDIRECT_CHANNELS_MAX - 3. */
int indirect_filter_with_error(const struct plan *plan, const struct patch *patch,
                               struct rect inner, uint32_t count, const float *const *in,
                               float *const *out, float *width_px,
                               const struct indirect_error *error,
                               struct indirect_statistics *statistics);
