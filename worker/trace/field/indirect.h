#pragma once
/* The light field of indirect light: stratified cosine-distributed rays from what is seen through
 * pixel centres, each going on as a path (path.h); and how far they come, for filters and for
 * ambient occlusion.
 *
 * Sample i of a pixel has its direction from the dimension PATTERN_INDIRECT: stratum (u, v), mapped
 * by lambert_sample, or for the sheared filter by proto/v_plane.h, around the shading normal. The
 * tangents are v_plane_tangents in the camera's axes (right, up, -forward), which vary smoothly
 * over a surface (docs/reconstruction.md, V-plane filter). Its later random numbers are
 * pattern_path.h's, by path_field_key.
 *
 * Rays of later passes are stratified by themselves, under a seed of their own; those of a second
 * set (plan_rate) pixel by pixel, each with its own number of strata.
 *
 * A sample's radiance is what a white surface's diffuse lobe would send to the camera of light that
 * was scattered before, at least once and at most plan.bounces times: their mean times albedo is
 * the picture's. Rays below the facet bring nothing and count as blocked. Where fields light lens
 * samples from a sky (LENS_LIGHT_SKY), rays that miss bring its soft share, too. */
#include "proto/samples.h"
#include "worker/trace/light/strata.h"
#include "worker/trace/path/path.h"

/* Tangents of unit normals, in world space. */
void indirect_tangents(const struct plan_camera *camera, const struct lanes3 *normal,
                       struct lanes3 *tangent, struct lanes3 *bitangent);

struct indirect_sums {
    struct lanes3 half[2];                                       /* of even samples, of odd ones */
    _Alignas(LANES_ALIGN) float nearest[LANES], farthest[LANES]; /* INFINITY and 0: none */
    _Alignas(LANES_ALIGN) float open[LANES]; /* rays that come as far as the plan's distance */
};

struct indirect_scratch {
    struct strata strata;
    struct indirect_sums sums;
    /* the v-plane's columns and rows */
    _Alignas(LANES_ALIGN) float side[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    _Alignas(LANES_ALIGN) float height[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    _Alignas(LANES_ALIGN) float sine[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    _Alignas(LANES_ALIGN) float cosine[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
};

/* Traces the lanes of *lit, all with a surface in *from (path_resolve), into the planes of bounce
 * rays that `samples` has; without a plane of radiance, only the first rays and no farther than the
 * plan's occlusion_distance. c->field holds; paths->harvest is overwritten. */
void indirect_trace(const struct path_context *c, const struct block *block,
                    const struct path_vertex *from, const struct lanes_mask *lit,
                    struct indirect_scratch *scratch, struct path_scratch *paths,
                    struct samples *samples);
