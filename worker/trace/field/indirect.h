#pragma once
/* The light field of indirect light. Stratified cosine-distributed rays leave the surfaces at pixel
 * centres, and each continues as a path (path.h). Their lengths serve filters and ambient
 * visibility.
 *
 * Sample i of a pixel has its direction from the dimension PATTERN_INDIRECT: stratum (u, v), mapped
 * by lambert_sample, or for the sheared filter by proto/v_plane.h, around the shading normal. The
 * tangents are v_plane_tangents in the camera's axes (right, up, -forward), which vary smoothly
 * over a surface (docs/reconstruction.md, V-plane filter). Its later random numbers are
 * pattern_path.h's, by path_field_key.
 *
 * Rays of later passes have strata and a seed of their own. In a second set each pixel has its own
 * number of strata.
 *
 * A sample is the radiance that a white surface's diffuse lobe reflects to the camera. The light
 * was scattered before, at least once and at most plan.bounces times. The mean of the samples times
 * the albedo is the picture's radiance. Rays below the facet are black and count as blocked. Under
 * plan_sky_in_fields, rays that miss bring the soft share of the sky, too. */
#include "worker/trace/field/half_field.h"
#include "worker/trace/field/indirect_sums.h"
#include "worker/trace/light/strata.h"
#include "worker/trace/path/path.h"

/* Computes the tangents of unit normals, in world space. */
void indirect_tangents(const struct plan_camera *camera, const struct lanes3 *normal,
                       struct lanes3 *tangent, struct lanes3 *bitangent);

struct indirect_scratch {
    struct strata strata;
    struct indirect_sums sums;
    struct field_pack pack;
    /* the v-plane's columns and rows */
    _Alignas(LANES_ALIGN) float side[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    _Alignas(LANES_ALIGN) float height[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    _Alignas(LANES_ALIGN) float sine[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
    _Alignas(LANES_ALIGN) float cosine[LIMIT_PLANE_STRATA_PER_AXIS][LANES];
};

/* Traces *lanes, which have a surface in *from (path_resolve), into the planes of bounce rays in
 * `samples`; those that look around are the tile's own. Without a plane of radiance, only the first
 * rays are traced, up to the plan's occlusion_distance. c->field must hold; paths->radiance is
 * overwritten. With `half`, scratch for pixels of the image, only those of lanes->lit trace that it
 * chooses, and others look as if they had no rays. */
void indirect_trace(const struct path_context *c, const struct block *block,
                    const struct path_vertex *from, const struct bounce_lanes *lanes,
                    struct half_field *half, struct indirect_scratch *scratch,
                    struct path_scratch *paths, struct samples *samples);
