#pragma once
/* The light field of glossy lobes. Rays leave the surfaces at pixel centres by their visible
 * facets, and each continues as a path (path.h). worker/shade/glossy.h says which surfaces have
 * such a lobe.
 *
 * All pixels of a frame share one sequence of directions along a Morton curve (pattern_path.h),
 * around tangents that depend on the shading normal alone, or are those of an anisotropic material.
 * Later random numbers are a pixel's own,
 * by path_glossy_key.
 *
 * A sample is the radiance that the lobe reflects to the camera, over its directional albedo. The
 * light was scattered before, at least once and at most plan.bounces times. The mean of the samples
 * times the albedo is the picture's radiance. Rays below the facet count as black. Under
 * plan_sky_in_fields, rays that miss bring the soft share of the sky, too. */
#include "proto/samples.h"
#include "worker/trace/field/field_pack.h"
#include "worker/trace/field/half_field.h"
#include "worker/trace/path/glossy_lobes.h"

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
    struct field_pack pack;
};

/* Traces the kept lanes of scratch->lobes, which have a surface in *from, into the planes of glossy
 * lobes in `samples`. Each lane gets l^2 rays. In a second set it gets its own number of strata
 * squared, along a curve of its own for each number. c->field must hold; paths->radiance is
 * overwritten. With `half`, scratch for pixels of the image, only those trace that it chooses, and
 * others have no weight. */
void glossy_trace(const struct path_context *c, const struct block *block,
                  const struct path_vertex *from, struct half_field *half,
                  struct glossy_scratch *scratch, struct path_scratch *paths,
                  struct samples *samples);
