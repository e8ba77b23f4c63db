#pragma once
/* What the bounce rays of a block's pixels bring, in all. */
#include "proto/samples.h"
#include "worker/trace/field/field_pack.h"

struct indirect_sums {
    struct lanes3 half[2];                                       /* of even samples, of odd ones */
    _Alignas(LANES_ALIGN) float nearest[LANES], farthest[LANES]; /* INFINITY and 0: none */
    _Alignas(LANES_ALIGN) float open[LANES]; /* rays that reach the plan's distance */
};

/* Lanes whose rays bring light, and others whose rays only look how far they come. */
struct bounce_lanes {
    struct lanes_mask lit, looking;
};

void indirect_sums_clear(struct indirect_sums *sums);

/* Adds a sample to half `field` & 1; rays are open that come as far as `distance`. */
void indirect_sums_add(const struct field_sample *sample, float distance, uint32_t field,
                       struct indirect_sums *sums);

/* Stores means of `rays` samples a lane, and distances of the lanes that traced, into planes of
 * bounce rays. */
void indirect_sums_store(const struct plan *plan, const struct block *block,
                         const struct bounce_lanes *lanes, const uint32_t rays[LANES],
                         const struct indirect_sums *sums, struct samples *samples);
