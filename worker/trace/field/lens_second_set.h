#pragma once
/* Second sets of paths through the lens: PLAN_LENS_EXTRA_STRATA^2 more for selected pixels. They
 * use the path tracer's own points of the lens, which are spread more evenly than a pattern for
 * filters. */
#include "proto/samples.h"
#include "worker/trace/path/path.h"

/* The first path of second sets. It lies behind all samples of a first set, at a multiple of every
 * power of two that a set may have, where the sequence is stratified anew. */
#define LENS_SECOND_SET_FIRST (LIMIT_PLANE_STRATA_PER_AXIS * LIMIT_PLANE_STRATA_PER_AXIS)

struct lens_second_set {
    struct block block;   /* its kept pixels have a second set */
    double sum[LANES][4]; /* radiance, and the sum of its squares */
    _Alignas(LANES_ALIGN) float seen[LANES];
};

/* Traces the pixels of the block to which the tile's `strata_map` gives PLAN_LENS_EXTRA_STRATA,
 * into PLANES_LENS_SECOND_SET as far as `samples` has them. paths->radiance is overwritten. */
void lens_second_set_trace(const struct path_context *c, const struct block *block,
                           const uint8_t *strata_map, struct lens_second_set *m,
                           struct path_scratch *paths, struct samples *samples);
