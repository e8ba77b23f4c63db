#pragma once
/* The light field of the lens: l x l paths a pixel, each through its own stratum of the aperture
 * (proto/lens_pattern.h) and a point of the pixel that the path tracer would take. What each brings
 * and how its first hit moves with the lens travels sample by sample: filters shear them against
 * each other. */
#include "proto/lens_pattern.h"
#include "proto/samples.h"
#include "worker/trace/path/path.h"

struct lens_scratch {
    struct lens_pattern pattern;
    /* The lines on which a block's points lie, and how far along these their columns do. */
    float height[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    float left[LIMIT_PLANE_STRATA_PER_AXIS][LANES], right[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    float along[LANES];
    uint32_t keys[LANES];
    _Alignas(LANES_ALIGN) float seen[LANES]; /* samples that meet a surface */
};

/* For blocks of the plan, which has lens samples. */
void lens_scratch_init(struct lens_scratch *s, const struct plan *plan);

/* The paths of one lens sample of the block's kept pixels join the pool, which is emptied first:
 * for path_trace_camera. */
void lens_begin(const struct path_context *c, const struct block *b, uint32_t sample,
                struct lens_scratch *s, struct path_pool *pool);

/* Traces all lens samples of the block's kept pixels into the planes of lens samples that `samples`
 * has. c->lens holds; paths->harvest is overwritten. */
void lens_trace(const struct path_context *c, const struct block *block, struct lens_scratch *s,
                struct path_scratch *paths, struct samples *samples);
