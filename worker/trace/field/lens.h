#pragma once
/* The light field of the lens: l x l paths for each pixel, each through its own stratum of the
 * aperture (proto/lens_pattern.h) and the path tracer's own point of the pixel. Each sample keeps
 * its radiance and the slope of its first hit, by which filters shear the samples. */
#include "proto/lens_pattern.h"
#include "proto/samples.h"
#include "worker/trace/path/path.h"
#include "worker/trace/path/path_sums.h"

struct lens_scratch {
    struct lens_pattern pattern;
    /* The lines on which a block's points lie, and how far along these their columns do. */
    float height[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    float left[LIMIT_PLANE_STRATA_PER_AXIS][LANES], right[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    float along[LANES];
    uint32_t keys[LANES];
    _Alignas(LANES_ALIGN) float seen[LANES]; /* samples that meet a surface */
};

/* Prepares the scratch for a plan with lens samples. */
void lens_scratch_init(struct lens_scratch *s, const struct plan *plan);

/* Fills the pool with the paths of one lens sample of the block's kept pixels, for
 * path_trace_camera. */
void lens_begin(const struct path_context *c, const struct block *b, uint32_t sample,
                struct lens_scratch *s, struct path_pool *pool);

/* Traces all lens samples of the block's kept pixels into the planes of lens samples that `samples`
 * has. c->lens must hold; paths->radiance is overwritten. Where the plan has paths, too, these are
 * the same: *sums becomes their sum, which is stored in their planes. */
void lens_trace(const struct path_context *c, const struct block *block, struct lens_scratch *s,
                struct path_scratch *paths, struct path_sums *sums, struct samples *samples);
