#pragma once
/* The light field of a light at pixel centres: the visibility, irradiance and slope of all strata.
 */
#include "proto/samples.h"
#include "worker/trace/light/light.h"
#include "worker/trace/light/shadow_sums.h"
#include "worker/trace/light/strata.h"

struct light_kernels;

/* The input of one block, shared by all effects. */
struct shading_point {
    const struct light_kernels *kernels;
    const struct plan *plan;
    const struct block *block;
    const struct surface *surface;
    struct lanes_mask lit;     /* lanes inside the image with a surface that reflects something */
    struct lanes_mask counted; /* of these, the tile's own */
    uint32_t lit_count;
};

/* Scratch; the packets' rays as queries_init_rays left them. */
struct shadow_scratch {
    struct strata strata;
    struct shadow_sums sums;
    struct light_packet batch[SHADOW_BATCH];
};

/* Traces light `index` for the point's lanes into the planes of `samples`. A blocked stratum's
 * slope is t/(1-t), t the fraction of the way to the light at which it is blocked
 * (docs/reconstruction.md, Slopes and wedges); blockers' distances are asked for only if the plan
 * has the slopes plane. */
void shadow_trace(struct queries *q, const struct light *light, uint32_t index,
                  const struct shading_point *point, struct shadow_scratch *scratch,
                  struct samples *samples, struct counters *counters);

/* Fills the planes of light `index` for a block without rays: every stratum counts as visible. */
void shadow_store_unlit(uint32_t index, const struct shading_point *point, struct samples *samples);
