#pragma once
/* The light field of a light at pixel centres: the visibility, irradiance and slope of all strata.
 */
#include "proto/samples.h"
#include "worker/trace/light/light.h"
#include "worker/trace/light/shadow_sums.h"
#include "worker/trace/light/strata.h"
#include "worker/trace/path/layers.h"

struct light_kernels;
struct path_kernels;

/* The input of one block, shared by all effects. */
struct shading_point {
    const struct light_kernels *kernels;
    const struct plan *plan;
    const struct block *block;
    const struct surface *surface;
    struct lanes_mask lit;     /* lanes inside the image with a surface that reflects something */
    struct lanes_mask counted; /* of these, the tile's own */
    uint32_t lit_count;
    const struct path_vertex *vertex; /* of the surface, where its lobes weigh light; else NULL */
    const struct path_kernels *path_kernels; /* with it */
    struct layers layers;                    /* of it: shading_point_see sets them */
};

/* Gives the point the layers of its surfaces. */
void shading_point_see(const struct path_kernels *kernels, const struct path_vertex *vertex,
                       struct shading_point *point);

/* Sums over a light's strata, seen or not: of irradiance, and of what diffuse lobes make of it. */
struct diffuse_sums {
    _Alignas(LANES_ALIGN) float all[LANES], weighed[LANES];
};

/* Scratch; the packets' rays as queries_init_rays left them. */
struct shadow_scratch {
    struct strata strata;
    struct shadow_sums sums;
    struct diffuse_sums diffuse;
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
