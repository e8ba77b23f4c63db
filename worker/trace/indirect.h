#pragma once
/* One bounce of indirect light: cosine-distributed rays from camera hits, lit where they land by
 * one point of one light, chosen by power.
 *
 * Sample i of a pixel has its direction from the dimension PATTERN_INDIRECT: stratum (u, v), mapped
 * by lambert_sample around the shading normal. The tangents are those of Frisvad (2012, "Building
 * an orthonormal basis from a 3D unit vector without normalization") in the camera's axes (right,
 * up, -forward), whose pole lies where no visible normal points, so that they vary smoothly over a
 * surface (filters.md section 3). */
#include "worker/scene/light_table.h"
#include "worker/trace/shadow.h"

/* Tangents of unit normals, in world space. */
void indirect_tangents(const struct plan_camera *camera, const struct lanes3 *normal,
                       struct lanes3 *tangent, struct lanes3 *bitangent);

/* Scratch; rays as queries_init_rays left them. */
struct indirect_scratch {
    struct RTCRayHit16 bounce;
    struct light_packet shadow, candidate;
    struct strata strata;
    struct surface landing;
    struct pattern_deck choice[LANES], position[LANES]; /* a pixel's light and point on it */
};

/* Traces the point's lanes into the indirect planes of `samples`. */
void indirect_trace(struct queries *q, const struct light_table *lights,
                    const struct shading_point *point, struct indirect_scratch *scratch,
                    struct samples *samples, struct counters *counters);
