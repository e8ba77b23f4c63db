#pragma once
/* The light field of glossy lobes: rays by the visible facets of what is seen through pixel
 * centres, each going on as a path (path.h), for the surfaces that worker/shade/glossy.h names.
 *
 * All pixels of a frame share one sequence of directions along a Morton curve (pattern_path.h),
 * around tangents that only the shading normal decides. Later random numbers are a pixel's own, by
 * path_glossy_key.
 *
 * A sample's radiance is what the lobe sends to the camera of light that was scattered before, at
 * least once and at most plan.bounces times, over the lobe's directional albedo: their mean times
 * that is the picture's. Rays below the facet bring nothing and count. Where fields light lens
 * samples from a sky (LENS_LIGHT_SKY), rays that miss bring its soft share, too. */
#include "proto/samples.h"
#include "worker/trace/path/glossy_lobes.h"

void glossy_store_lobes(const struct path_context *c, const struct block *b,
                        const struct glossy_lobes *lobes, struct samples *samples);
void glossy_store_sub(const struct path_context *c, const struct block *b, uint32_t sub,
                      const struct glossy_lobes *lobes, struct samples *samples);

struct glossy_sums {
    struct lanes3 light; /* weight times radiance, over the reflectance */
    struct lanes3 half;  /* the same of the pixel's half of the samples (PLANE_GLOSSY_HALF) */
    _Alignas(LANES_ALIGN) float weight[LANES], nearness[LANES], traced[LANES];
    _Alignas(LANES_ALIGN) float half_weight[LANES];
    _Alignas(LANES_ALIGN) float nearest[LANES], farthest[LANES]; /* hits; INFINITY, 0: none */
};

struct glossy_scratch {
    struct glossy_lobes lobes;
    struct glossy_sums sums;
};

/* Traces the kept lanes of scratch->lobes, all with a surface in *from, into the planes of glossy
 * lobes that `samples` has: l^2 rays each, or in a second set as many as the lobe's own side says,
 * along a curve of their own for each number. c->field holds; paths->harvest is overwritten. */
void glossy_trace(const struct path_context *c, const struct block *block,
                  const struct path_vertex *from, struct glossy_scratch *scratch,
                  struct path_scratch *paths, struct samples *samples);
