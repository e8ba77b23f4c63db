#pragma once
/* Which pixels of a block trace rays of a field at half resolution (proto/half_field.h). It depends
 * on the block alone, whatever tile keeps its pixels.
 *
 * First the nodes trace. Then pixels do that do not lie between nodes of their own surface, some of
 * which are nodes around the block, and pixels of which the nodes' rays tell that light changes
 * from pixel to pixel. */
#include "proto/half_field.h"
#include "worker/trace/field/half_field_ring.h"
#include "worker/trace/hit/block.h"
#include "worker/trace/hit/hit.h"
#include "worker/trace/path/glossy_lobes.h"

struct half_field {
    struct half_field_ring ring;
    struct shown_surface shown[LANES];
    uint16_t nodes[LANES];     /* as bits: lanes of nodes that may stand for the lane; 0: none */
    struct lanes_mask traced;  /* so far: at first nodes */
    struct lanes_mask waiting; /* kept lanes that are no nodes */
};

/* Finds the nodes among the lanes of *lit, half->traced. They trace though another tile keeps them,
 * as their rays tell of lanes that this one keeps. `surface` has what the lanes show; half->ring
 * has been seen. */
void half_field_init(const struct block *block, const struct surface *surface,
                     const struct lanes_mask *lit, struct half_field *half);

/* Find which waiting lanes trace after all, *more, by what the nodes' rays met: the nearest of it,
 * INFINITY for nothing; or what lobes see, whose mean of 1 / distance is `nearness`. They become
 * traced. Lanes have strata x strata rays, which *counters get. */
void half_field_refine(const float *nearest, uint32_t strata, struct half_field *half,
                       struct lanes_mask *more, struct counters *counters);
void half_field_refine_lobes(const struct glossy_lobes *lobes, const float *nearness,
                             uint32_t strata, struct half_field *half, struct lanes_mask *more,
                             struct counters *counters);
